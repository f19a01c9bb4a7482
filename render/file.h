// Whole files in, whole files out: reading with errors that name the file, and writing that never
// leaves half a file behind.
#pragma once

#include <functional>
#include <string>

namespace opaline {

/// The bytes of a file. Throws InputError when it is missing, a folder, or unreadable.
std::string read_file(const std::string& path);

/// Calls `write(temporary)` with a free name beside `path` that has the same extension, then
/// renames the result to `path`. `write` reports failure by an exception; then, or when the rename
/// fails, the temporary is removed and InputError(path, "", "cannot be written: ...") thrown.
void write_file_atomically(const std::string& path, const std::function<void(const std::string& temporary)>& write);

}  // namespace opaline
