// What is concluded from records: fronts, advice, gates, JUnit, baselines.
#include "render/input_error.h"
#include "tests/render/scene_fixture.h"
#include "validate/advice.h"
#include "validate/baseline.h"
#include "validate/junit.h"
#include "validate/pareto.h"

#include <gmock/gmock.h>

#include <limits>
#include <random>

namespace opaline {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::HasSubstr;

Record record(const std::string& scene, const std::string& technique, double seconds, double error) {
  Record r;
  r.scene = scene, r.material = "m", r.technique = technique, r.backend = "cpu";
  r.seconds.prepare = make_timing({0});
  r.seconds.render = make_timing({seconds, seconds});
  r.error = {{"relative_rmse", error}};
  r.done = {{"rays", 100}};
  r.film_pixels = 100;
  return r;
}

TEST(Pareto, TheFrontIsWhatNothingBeats) {
  std::mt19937 engine(7);
  std::uniform_int_distribution<int> coarse(1, 12);  // so that values tie
  for (int round = 0; round < 50; ++round) {
    std::vector<CostPoint> points;
    for (std::size_t i = 0; i < 40; ++i)
      points.push_back({i, static_cast<double>(coarse(engine)), static_cast<double>(coarse(engine))});
    const std::vector<CostPoint> front = pareto_front(points);
    const auto beats = [](const CostPoint& a, const CostPoint& b) {
      return a.seconds <= b.seconds && a.error <= b.error && (a.seconds < b.seconds || a.error < b.error);
    };
    for (std::size_t i = 1; i < front.size(); ++i) {
      EXPECT_LT(front[i - 1].seconds, front[i].seconds);
      EXPECT_GT(front[i - 1].error, front[i].error);
    }
    for (const CostPoint& p : points) {
      const bool beaten = std::any_of(points.begin(), points.end(), [&](const CostPoint& q) { return beats(q, p); });
      const bool in_front = std::any_of(
          front.begin(), front.end(), [&](const CostPoint& q) { return q.seconds == p.seconds && q.error == p.error; });
      EXPECT_NE(beaten, in_front);
    }
  }
}

TEST(Pareto, LimitsPickFromTheFront) {
  const std::vector<CostPoint> front = pareto_front({{0, 1, 0.1}, {1, 2, 0.01}, {2, 3, 0.001}, {3, 4, 0.5}});
  EXPECT_EQ(cheapest_under(front, 0.02)->record, 1u);
  EXPECT_EQ(cheapest_under(front, 1e-4), nullptr);
  EXPECT_EQ(most_accurate_under(front, 2.5)->record, 1u);
  EXPECT_EQ(most_accurate_under(front, 0.5), nullptr);
}

TEST(Pareto, LeavesOutWhatHasNoError) {
  std::vector<Record> records = {record("a", "x", 1, 0.1), record("a", "y", 2, 0.2), record("a", "z", 3, HUGE_VAL)};
  records[1].status = CellStatus::failed;
  EXPECT_EQ(cost_points(records, "relative_rmse").size(), 1u);
}

TEST(Advice, JudgesByTheWorstSceneAndScalesTheFrame) {
  std::vector<Record> records = {record("a", "fast", 1, 0.01), record("b", "fast", 1, 0.2),
                                 record("a", "good", 5, 0.02), record("b", "good", 4, 0.03),
                                 record("a", "partial", 0.1, 0.001)};
  records[0].seconds.prepare = make_timing({0.5});
  const std::vector<Way> all = ways(records, 200);
  ASSERT_EQ(all.size(), 2u) << "one without an error on every scene is left out";
  EXPECT_EQ(all[0].worst_error, 0.2);
  EXPECT_EQ(all[0].worst_scene, "b, m");
  EXPECT_EQ(all[0].expected_seconds, 2.5);
  ASSERT_EQ(fastest_within_error(all, 0.05).size(), 1u);
  EXPECT_EQ(fastest_within_error(all, 0.05)[0].technique, "good");
  EXPECT_EQ(fastest_within_error(all, 0.5)[0].technique, "fast");
  EXPECT_EQ(most_accurate_within(all, 100)[0].technique, "good");
  EXPECT_EQ(most_accurate_within(all, 3)[0].technique, "fast");
  EXPECT_TRUE(most_accurate_within(all, 1).empty());
}

TEST(Advice, ScenesThatATechniqueCannotRenderDontCountAgainstIt) {
  std::vector<Record> records = {record("head", "profile", 1, 0.01), record("fish", "profile", 1, 0),
                                 record("head", "layers", 2, 0),     record("fish", "layers", 2, 0.02),
                                 record("head", "broken", 3, 0.01),  record("fish", "broken", 3, 0)};
  records[1].status = records[2].status = CellStatus::not_applicable;
  records[5].status = CellStatus::failed;
  const std::vector<Way> all = ways(records, 100);
  ASSERT_EQ(all.size(), 2u) << "what failed counts";
  EXPECT_EQ(all[0].technique, "layers");
  EXPECT_EQ(all[0].worst_error, 0.02);
  EXPECT_EQ(all[1].technique, "profile");
  EXPECT_EQ(all[1].scenes, 1u);
}

json gates_document(const json& gate) { return {{"format", "opaline-gates"}, {"version", 1}, {"gates", {gate}}}; }

GateResult outcome(const json& gate, const std::vector<Record>& records) {
  return check_gates(parse_gates(gates_document(gate), "g.json").gates, records).at(0);
}

TEST(Gates, JudgeTheWorstSelectedRecord) {
  const std::vector<Record> records = {record("a", "x", 2, 0.1), record("b", "x", 6, 0.3), record("a", "y", 1, 0.5),
                                       record("b", "y", 2, 0.5)};
  const auto gate = [](const json& figure, const char* side, double limit) {
    return json{{"name", "g"}, {"figure", figure}, {side, limit}};
  };
  const json error = {{"error", "relative_rmse"}, {"technique", "x"}};
  EXPECT_EQ(outcome(gate(error, "max", 0.3), records).outcome, GateResult::Outcome::passed);
  const GateResult failed = outcome(gate(error, "max", 0.29), records);
  EXPECT_EQ(failed.outcome, GateResult::Outcome::failed);
  EXPECT_EQ(failed.value, 0.3);
  EXPECT_THAT(failed.where, HasSubstr("b/m x"));
  EXPECT_EQ(outcome(gate(error, "min", 0.2), records).value, 0.1);
  EXPECT_EQ(outcome(gate({{"counter", "done.rays"}}, "max", 99), records).outcome, GateResult::Outcome::failed);
  EXPECT_EQ(outcome(gate({{"count", "failed"}}, "max", 0), records).outcome, GateResult::Outcome::passed);
  json ratio = gate({{"seconds", "render"}, {"technique", "x"}}, "max", 2.5);
  ratio["divided_by"] = {{"seconds", "render"}, {"technique", "y"}};
  const GateResult slow = outcome(ratio, records);
  EXPECT_EQ(slow.value, 3) << "6 / 2 on b, not 6 / 1 across scenes";
  EXPECT_EQ(slow.outcome, GateResult::Outcome::failed);
}

TEST(Gates, DivideATechniqueByItselfWithTheSameSettings) {
  std::vector<Record> records = {record("a", "x", 1, 0.1), record("a", "x", 1, 0.4), record("a", "x", 1, 0.1),
                                 record("a", "x", 1, 0.4)};
  records[0].settings = records[2].settings = {{"n", "8"}};
  records[1].settings = records[3].settings = {{"n", "1"}};
  records[2].backend = records[3].backend = "gpu";
  json gate = {{"name", "twins"},
               {"figure", {{"error", "relative_rmse"}, {"backend", "gpu"}}},
               {"divided_by", {{"error", "relative_rmse"}, {"backend", "cpu"}}},
               {"max", 1}};
  EXPECT_EQ(outcome(gate, records).value, 1);
  gate["divided_by"]["settings"] = {{"n", 8}};
  EXPECT_EQ(outcome(gate, records).value, 4);
}

TEST(Gates, FailWithoutRecordsOrNumbersAndSkipWhatIsNotApplicable) {
  std::vector<Record> records = {record("a", "x", 1, std::numeric_limits<double>::infinity()), record("a", "y", 1, 1)};
  records[1].status = CellStatus::not_applicable;
  const auto of = [&](const char* technique) {
    return outcome({{"name", "g"}, {"figure", {{"error", "relative_rmse"}, {"technique", technique}}}, {"max", 9}},
                   records)
        .outcome;
  };
  EXPECT_EQ(of("x"), GateResult::Outcome::failed) << "infinite";
  EXPECT_EQ(of("y"), GateResult::Outcome::skipped);
  EXPECT_EQ(of("z"), GateResult::Outcome::failed) << "a gate about nothing";
  records[0].status = CellStatus::failed;
  EXPECT_EQ(outcome({{"name", "g"}, {"figure", {{"count", "failed"}}}, {"max", 0}}, records).value, 1);
  EXPECT_EQ(of("x"), GateResult::Outcome::failed);
}

TEST(Gates, RefuseWhatIsWrong) {
  const auto refusal = [](const json& gate) {
    return test::message_of([&] { parse_gates(gates_document(gate), "g.json"); });
  };
  const json error = {{"error", "rmse"}};
  EXPECT_THAT(refusal({{"name", "g"}, {"figure", {{"seconds", "render"}}}, {"max", 1}}), HasSubstr("absolute time"));
  EXPECT_THAT(refusal({{"name", "g"}, {"figure", {{"error", "rmsee"}}}, {"max", 1}}),
              AllOf(HasSubstr("/gates/0/figure/error"), HasSubstr("did you mean \"rmse\"")));
  EXPECT_THAT(refusal({{"name", "g"}, {"figure", {{"counter", "rays"}}}, {"max", 1}}), HasSubstr("done.NAME"));
  EXPECT_THAT(refusal({{"name", "g"}, {"figure", error}}), HasSubstr("exactly one of \"max\" and \"min\""));
  EXPECT_THAT(refusal({{"name", "g"}, {"figure", json::object()}, {"max", 1}}), HasSubstr("exactly one of \"error\""));
  EXPECT_THAT(refusal({{"name", "g"}, {"figure", error}, {"maximum", 1}}), HasSubstr("max"));
  EXPECT_THAT(refusal({{"figure", error}, {"max", 1}}), HasSubstr("\"name\" is missing"));
  EXPECT_THAT(test::message_of([] { find_gates("quik"); }), HasSubstr("quick"));
  EXPECT_FALSE(find_gates("quick").gates.empty());
}

TEST(Junit, CountsAndEscapes) {
  std::vector<Record> records = {record("a", "x", 1, 1), record("a", "y", 1, 1)};
  records[0].status = CellStatus::failed, records[0].reason = "a < b & \"c\"\x01";
  records[1].status = CellStatus::not_applicable;
  const std::string xml = junit_xml("s",
                                    {{"g", GateResult::Outcome::failed, 2, 1, true, "here", "2 > 1"},
                                     {"h", GateResult::Outcome::passed, 0, 1, true, "", ""}},
                                    records);
  EXPECT_THAT(xml,
              HasSubstr("<testsuite name=\"opaline.s.gates\" tests=\"2\" failures=\"1\" errors=\"0\" skipped=\"0\">"));
  EXPECT_THAT(xml,
              HasSubstr("<testsuite name=\"opaline.s.cells\" tests=\"2\" failures=\"0\" errors=\"1\" skipped=\"1\">"));
  EXPECT_THAT(xml, HasSubstr("message=\"a &lt; b &amp; &quot;c&quot;?\""));
  EXPECT_THAT(xml, HasSubstr("<failure message=\"2 &gt; 1: here\"/>"));
}

TEST(Baseline, CountersThatAppearOrVanishAreChanges) {
  std::vector<Record> before = {record("a", "x", 1, 0.1)}, now = before;
  before[0].done["clusters"] = 7, before[0].skipped["rays_dark"] = 0;
  now[0].done["cells"] = 9, now[0].skipped["rays_far"] = 3;
  const BaselineComparison c = compare_with_baseline(before, now);
  std::map<std::string, std::pair<double, double>> found;
  for (const Change& change : c.changes) found[change.what] = {change.before, change.now};
  const std::map<std::string, std::pair<double, double>> expected = {{"counter done.clusters (gone)", {7, 0}},
                                                                     {"counter done.cells (new)", {0, 9}},
                                                                     {"counter skipped.rays_dark (gone)", {0, 0}},
                                                                     {"counter skipped.rays_far (new)", {0, 3}}};
  EXPECT_EQ(found, expected);
  EXPECT_FALSE(c.any_worse());
}

TEST(Baseline, TellsAChangeFromNoiseAndFromAnotherMachine) {
  std::vector<Record> before, now;
  for (int i = 0; i < 9; ++i) {
    before.push_back(record("s" + std::to_string(i), "x", 1, 0.1));
    before.back().seconds.render = make_timing({1, 1.05, 0.98});
    now.push_back(before.back());
    now.back().seconds.render = make_timing({2, 2.1, 1.96});  // a machine of half the speed
  }
  EXPECT_TRUE(compare_with_baseline(before, now).changes.empty());
  EXPECT_NEAR(compare_with_baseline(before, now).machine_factor, 2, 1e-12);
  now[3].seconds.render = make_timing({3, 3.2, 3.1});
  now[4].seconds.render = make_timing({1.9, 6, 2.6});  // the median is slow, the fastest isn't
  now[5].error["relative_rmse"] = 0.12;
  now[6].done["rays"] = 101;
  now[7].status = CellStatus::failed;
  now[8].error["relative_rmse"] = 0.05;
  const BaselineComparison c = compare_with_baseline(before, now);
  ASSERT_EQ(c.changes.size(), 5u);
  const auto find = [&](const std::string& scene) {
    return *std::find_if(c.changes.begin(), c.changes.end(),
                         [&](const Change& change) { return change.cell.rfind(scene + "/", 0) == 0; });
  };
  EXPECT_TRUE(find("s3").worse);
  EXPECT_EQ(find("s3").what, "render seconds");
  EXPECT_TRUE(find("s5").worse);
  EXPECT_FALSE(find("s6").worse);
  EXPECT_EQ(find("s6").what, "counter done.rays");
  EXPECT_TRUE(find("s7").worse);
  EXPECT_FALSE(find("s8").worse);
  EXPECT_EQ(c.compared, 8u);
  EXPECT_TRUE(c.any_worse());
}

}  // namespace
}  // namespace opaline
