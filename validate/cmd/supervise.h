// A run that outlives the crash of a cell: the work is done in a child process, and when that dies the cell it was at
// fails and the rest goes on.
#pragma once

#include <functional>
#include <map>
#include <string>

namespace opaline {

/// Calls work(failed) in a child process, this program begun again with the same arguments, where `failed` tells of the
/// cells (by hash) that killed a child before, and why. `marker`: the file in which the child says which cell it is at.
/// Returns in the child alone, when work is done; this process ends with the child's exit code. A child that is
/// interrupted or terminated from outside is not begun again.
void supervise(const std::string& marker, const std::function<void(const std::map<std::string, std::string>&)>& work);

}  // namespace opaline
