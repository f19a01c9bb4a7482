// How `opaline render` chooses a technique by a limit instead of a name. The choice is made from measurements, which
// are none of this folder's business: the program hands the command a function that knows them.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace opaline {

/// One of the two limits is set.
struct ChoiceRequest {
  std::optional<double> max_error;       ///< relative_rmse
  std::optional<double> budget_seconds;  ///< for a first picture
  std::string records;                   ///< folder of records
  std::string backend;                   ///< only this one; empty: any
  double pixels = 0;                     ///< of the film
};

struct TechniqueChoice {
  std::string technique, backend;
  std::map<std::string, std::string> settings;
  std::size_t samples = 0;  ///< surface cells it was measured with
  std::string why;          ///< one sentence
};

/// The choices that keep the limit, best first; never none. Throws InputError when nothing measured keeps it, saying
/// what comes nearest.
using TechniqueChooser = std::function<std::vector<TechniqueChoice>(const ChoiceRequest&)>;

}  // namespace opaline
