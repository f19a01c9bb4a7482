// The exit codes are those of every command: see there.
#pragma once

#include "model/cmd/exit_status.h"
