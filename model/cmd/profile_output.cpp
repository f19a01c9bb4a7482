#include "model/cmd/profile_output.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>

namespace opaline {
namespace {

using Json = nlohmann::ordered_json;

const Json units = {{"r", "mm"}, {"R", "1/mm^2"}, {"total", "1"}, {"cumulative", "1"}, {"T", "1/mm^2"}};

Json channels_of(const TabulatedModel& model) {
  Json channels = Json::array();
  for (const TabulatedChannel& c : model.channels) {
    channels.push_back({{"r", c.r}, {"R", c.R}, {"total", c.total}, {"cumulative", c.cumulative}});
    if (c.transmittance.empty()) continue;
    channels.back()["T"] = c.transmittance;
    channels.back()["total_transmittance"] = c.total_transmittance;
  }
  return channels;
}

/// Mean |log(R/R_first)| over the radii where both are above 0.
double mean_log_ratio(const TabulatedChannel& first, const TabulatedChannel& c) {
  double sum = 0;
  int count = 0;
  for (std::size_t i = 0; i < c.R.size(); ++i) {
    if (!(c.R[i] > 0 && first.R[i] > 0)) continue;
    sum += std::abs(std::log(c.R[i] / first.R[i]));
    ++count;
  }
  return count ? sum / count : 0;
}

Json compared(const TabulatedModel& first, const TabulatedModel& model) {
  Json all = Json::array();
  for (std::size_t c = 0; c < model.channels.size(); ++c) {
    const TabulatedChannel &a = first.channels[c], &b = model.channels[c];
    all.push_back({{"total_ratio", a.total > 0 ? Json(b.total / a.total) : Json()},
                   {"mean_abs_log_ratio", mean_log_ratio(a, b)}});
  }
  return all;
}

struct Column {
  std::string name;
  const std::vector<double>* values;
};

std::vector<Column> columns_of(const TabulatedModel& model, bool several, bool all) {
  const char* const colours[] = {"_red", "_green", "_blue"};
  const bool rgb = model.channels.size() == 3;
  const std::string prefix = several ? model.name + "_" : "";
  std::vector<Column> columns;
  for (std::size_t c = 0; c < model.channels.size(); ++c) {
    const TabulatedChannel& channel = model.channels[c];
    const std::string colour = rgb ? colours[c] : "";
    columns.push_back({prefix + "R" + colour + "_per_mm2", &channel.R});
    if (!all) continue;
    columns.push_back({prefix + "cumulative" + colour, &channel.cumulative});
    if (!channel.transmittance.empty()) columns.push_back({prefix + "T" + colour + "_per_mm2", &channel.transmittance});
  }
  return columns;
}

}  // namespace

TabulatedChannel tabulate(const ProfileInfo& info, const Profile& profile, const std::vector<double>& radii) {
  TabulatedChannel channel{radii, {}, {}, {}, profile.total(), profile.total_transmittance()};
  for (const double r : radii) {
    channel.R.push_back(profile.evaluate(r));
    channel.cumulative.push_back(profile.cumulative(r));
    if (info.has_transmittance) channel.transmittance.push_back(profile.transmittance(r));
  }
  return channel;
}

void print_profiles_json(const std::vector<TabulatedModel>& models) {
  if (models.size() == 1) {
    const Json json = {{"model", models[0].name}, {"units", units}, {"channels", channels_of(models[0])}};
    fmt::print("{}\n", json.dump());
    return;
  }
  Json json = {{"units", units}, {"models", Json::array()}};
  for (const TabulatedModel& model : models) {
    json["models"].push_back({{"model", model.name}, {"channels", channels_of(model)}});
    if (&model != &models[0]) json["models"].back()["against_" + models[0].name] = compared(models[0], model);
  }
  fmt::print("{}\n", json.dump());
}

void print_profiles_csv(const std::vector<TabulatedModel>& models, bool all) {
  std::vector<Column> columns = {{"r_mm", &models[0].channels[0].r}};
  for (const TabulatedModel& model : models) {
    for (Column& column : columns_of(model, models.size() > 1, all)) columns.push_back(std::move(column));
  }
  for (const Column& c : columns) fmt::print("{}{}", &c == &columns[0] ? "" : ",", c.name);
  fmt::print("\n");
  for (std::size_t i = 0; i < columns[0].values->size(); ++i) {
    for (const Column& c : columns) fmt::print("{}{}", &c == &columns[0] ? "" : ",", (*c.values)[i]);
    fmt::print("\n");
  }
}

}  // namespace opaline
