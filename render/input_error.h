// The one exception for bad user input. Commands turn it into one message and exit code 2.
#pragma once

#include <stdexcept>
#include <string>

namespace opaline {

/// Bad input: `what()` reads "<file>: <place>: <what is wrong>; <valid choices>".
/// place  JSON pointer ("/materials/m1/eta"), "line 12", "triangle 17", or empty.
class InputError : public std::runtime_error {
 public:
  InputError(const std::string& file, const std::string& place, const std::string& problem)
      : std::runtime_error(place.empty() ? file + ": " + problem : file + ": " + place + ": " + problem) {}
};

/// The machine lacks something (no memory, no device). Commands exit with code 3.
class MachineError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

}  // namespace opaline
