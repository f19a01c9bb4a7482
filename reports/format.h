// Numbers as people read them.
#pragma once

#include <cstdint>
#include <string>

namespace opaline {

/// "1.23 s", "45.6 ms", "789 us": three digits, the unit that fits.
std::string seconds_text(double seconds);

/// A relative error as "1.23 %", below 0.01 % as "1.2e-5"; "not finite" for infinity or NaN.
std::string relative_text(double value);

/// Three significant digits; "not finite" for infinity or NaN.
std::string number_text(double value);

/// "12", "3.46 k", "1.2 M", "5 G".
std::string count_text(std::uint64_t count);

/// "12.3 MB" (10^6 bytes).
std::string bytes_text(std::uint64_t bytes);

/// "image_space_sampling" as "image space sampling".
std::string words(std::string name);

}  // namespace opaline
