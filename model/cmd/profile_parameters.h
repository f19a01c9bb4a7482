// What `opaline profile` reads beyond a medium: --set key=value and --layer. Errors as in medium_options.h, or
// ProfileParameterError; those in a file name it and the line.
#pragma once

#include "model/profiles/profile.h"

#include <string>
#include <vector>

namespace opaline {

/// The models of these names. Throws for an unknown one, or one that is named twice.
std::vector<const ProfileInfo*> models_of(const std::vector<std::string>& names);

/// --set key=value for these models: each gets what it declares. A key that none of them has is an error. The value of
/// a table of samples is a CSV file.
std::vector<ProfileParameters> parameters_of(const std::vector<const ProfileInfo*>& models,
                                             const std::vector<std::string>& settings);

/// --layer sigma_a,sigma_s_prime,eta,thickness_mm each, from the top down; "inf" for the last thickness.
std::vector<Layer> parse_layers(const std::vector<std::string>& texts);

/// The stack for these models: the first layer's thickness, and the others where a model takes them.
void add_layers(const std::vector<const ProfileInfo*>& models, const std::vector<Layer>& stack,
                std::vector<ProfileParameters>& parameters);

}  // namespace opaline
