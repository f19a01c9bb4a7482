// Fronts and bests against brute force; the papers' figures against hand counts.
#include "reports/analysis.h"
#include "reports/paper_figures.h"
#include "reports/techniques.h"
#include "tests/support/report_fixture.h"

#include <gmock/gmock.h>

#include <random>

namespace opaline {
namespace {

using ::testing::HasSubstr;

std::vector<Record> random_records(unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_int_distribution<int> step(1, 12);  // few values, so that ties are common
  std::vector<Record> records(40);
  for (Record& r : records) {
    r.seconds.render.median = 0.01 * step(random);
    r.error[headline_error] = 0.005 * step(random);
  }
  return records;
}

std::vector<const Record*> pointers(const std::vector<Record>& records) {
  std::vector<const Record*> all;
  for (const Record& r : records) all.push_back(&r);
  return all;
}

bool dominates(const Record& a, const Record& b) {
  const double ta = a.seconds.render.median, tb = b.seconds.render.median, ea = *error_of(a), eb = *error_of(b);
  return ta <= tb && ea <= eb && (ta < tb || ea < eb);
}

TEST(FrameFront, IsWhatNothingDominates) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    const auto records = random_records(seed);
    const auto front = frame_front(pointers(records));
    for (const Record* f : front)
      for (const Record& r : records) EXPECT_FALSE(dominates(r, *f));
    for (const Record& r : records) {
      const bool covered = std::any_of(front.begin(), front.end(), [&](const Record* f) {
        return f->seconds.render.median <= r.seconds.render.median && *error_of(*f) <= *error_of(r);
      });
      EXPECT_TRUE(covered) << "every record is at most as good as one of the front";
    }
    for (std::size_t i = 1; i < front.size(); ++i) EXPECT_LT(*error_of(*front[i]), *error_of(*front[i - 1]));
  }
}

TEST(FrameFront, LeavesOutWhatHasNoError) {
  auto records = random_records(3);
  records[0].status = CellStatus::failed, records[0].seconds.render.median = 1e-6;
  records[1].error[headline_error] = std::numeric_limits<double>::infinity(), records[1].seconds.render.median = 1e-6;
  for (const Record* r : frame_front(pointers(records))) EXPECT_GT(r->seconds.render.median, 1e-3);
  EXPECT_TRUE(frame_front({}).empty());
  EXPECT_EQ(most_accurate({}), nullptr);
}

TEST(Best, AgreesWithASearch) {
  const auto records = random_records(7);
  const Record* best = cheapest_within(pointers(records), 0.02);
  ASSERT_NE(best, nullptr);
  EXPECT_LE(*error_of(*best), 0.02);
  for (const Record& r : records) {
    if (*error_of(r) > 0.02) continue;
    EXPECT_GE(r.seconds.render.median, best->seconds.render.median);
  }
  EXPECT_EQ(cheapest_within(pointers(records), 1e-9), nullptr);
}

TEST(Groups, KeepEveryRecordOnce) {
  const auto records = test::made_up_records(100);
  std::size_t count = 0;
  for (const SceneGroup& g : scene_groups(records)) {
    count += g.records.size();
    for (const Record* r : g.records) EXPECT_EQ(r->scene + r->material, g.scene + g.material);
  }
  EXPECT_EQ(count, records.size());
}

TEST(PaperFigures, RatiosPairRecordsOfOneScene) {
  const auto records = test::made_up_records(100);
  const nlohmann::json ours = {{"quantity", "seconds.render"},
                               {"of", {{"settings", {{"samples", "512"}}}}},
                               {"over", {{"settings", {{"samples", "64"}}}}}};
  const auto ratios = figure_values(ours, "image_space_sampling", records);
  std::size_t expected = 0;
  for (const Record& r : records)
    expected +=
        r.technique == "image_space_sampling" && r.settings.at("samples") == "512" && r.status == CellStatus::done;
  ASSERT_EQ(ratios.size(), expected);
  for (const double ratio : ratios) EXPECT_NEAR(ratio, 8, 1e-9) << "time grows with the samples";
}

TEST(PaperFigures, SettingsLeftAloneHaveTheirDefaults) {
  Record r = test::made_up_record("s", "m", "image_space_sampling", 0, "cpu", 8);
  r.settings.clear();
  const nlohmann::json of = {{"quantity", "error.relative_rmse"}, {"of", {{"settings", {{"views", "camera"}}}}}};
  EXPECT_EQ(figure_values(of, "image_space_sampling", {r}).size(), 1u);
  r.settings["views"] = "camera+light";
  EXPECT_TRUE(figure_values(of, "image_space_sampling", {r}).empty());
  EXPECT_THROW(figure_values({{"quantity", "seconds"}}, "image_space_sampling", {r}), std::invalid_argument);
}

std::map<std::string, std::string> settings_of(const nlohmann::json& ours, const char* select) {
  if (!ours.contains(select) || !ours[select].contains("settings")) return {};
  return ours[select]["settings"];
}

std::string technique_of(const nlohmann::json& ours, const char* select, const std::string& own) {
  return ours.contains(select) ? ours[select].value("technique", own) : own;
}

/// A file that names a technique, a setting or a quantity nobody knows would show nothing, for ever.
TEST(PaperFigures, EveryFileSpeaksOfThingsThatExist) {
  const auto records = test::made_up_records(30);
  int checked = 0;
  for (const std::string& name : techniques_with_papers()) {
    SCOPED_TRACE(name);
    const nlohmann::json& document = paper_document(name);
    EXPECT_EQ(document.at("technique"), name);
    checked += registered_technique(name) != nullptr;
    for (const auto& figure : document.at("figures")) {
      EXPECT_FALSE(figure.at("what").get<std::string>().empty() || figure.at("where").get<std::string>().empty());
      if (!figure.contains("ours")) continue;
      EXPECT_NO_THROW(figure_values(figure["ours"], name, records)) << figure;
      for (const char* select : {"of", "over"})
        for (const auto& [key, value] : settings_of(figure["ours"], select))
          EXPECT_TRUE(registered_technique(name) == nullptr ||
                      technique_takes(technique_of(figure["ours"], select, name), key, value))
              << key << "=" << value;
    }
  }
  EXPECT_GE(checked, 2) << "files of techniques that are not registered yet are checked when they are";
}

}  // namespace
}  // namespace opaline
