// A bug trips a check: the process stops with the place and the broken condition. Checks are for
// the programmer's mistakes only; bad input throws InputError, numerics return a status.
#pragma once

#include <cstdio>
#include <cstdlib>

#define OPALINE_CHECK(condition)                                                                  \
  do {                                                                                            \
    if (!(condition)) {                                                                           \
      std::fprintf(stderr, "%s:%d: internal check failed: %s\n", __FILE__, __LINE__, #condition); \
      std::abort();                                                                               \
    }                                                                                             \
  } while (false)
