// Tables in files: kept, taken up again, and refused when they are not what they should be.
#include "render/transfer/transfer_file.h"

#include "render/file.h"
#include "tests/render/scene_fixture.h"
#include "tests/render/transfer_fixture.h"

#include <gmock/gmock.h>

namespace opaline {
namespace {

using testing::HasSubstr;

class TransferFiles : public testing::Test {
 protected:
  std::string name() const { return folder_.file("table.bin"); }

  Frame render(double sigma_a = 0.1, std::map<std::string, std::string> set = {}) const {
    Material material = test::library_material("skin1");
    material.sigma_a.r = sigma_a;
    const Scene scene = test::make_scene(make_sphere(5, 320), material, 11, 12);
    const SharedScene shared(scene, {600, {}}, false);
    const Technique& technique = find_technique("precomputed_transfer");
    set.try_emplace("lights", "any");
    set.try_emplace("directions", "80");
    set["file"] = name();
    return technique.prepare(shared, Settings(technique.settings, set))->render(shared.view);
  }
  std::string refusal(double sigma_a = 0.1, const std::map<std::string, std::string>& set = {}) const {
    return test::message_of([&] { render(sigma_a, set); });
  }
  void write(const std::string& file, const std::string& bytes) const {
    std::ofstream(file, std::ios::binary) << bytes;
  }

  test::TempFolder folder_;
};

TEST_F(TransferFiles, AreUsedInPlaceOfWork) {
  const Frame made = render();
  EXPECT_EQ(made.counters.done.at("parts"), 3u);
  EXPECT_EQ(folder_.file_count(), 1u);
  const Frame loaded = render();
  EXPECT_EQ(loaded.counters.skipped.at("parts_loaded"), 3u);
  EXPECT_EQ(loaded.counters.done.count("shadow_rays"), 0u);
  EXPECT_EQ(loaded.exitance, made.exitance);
  // What is kept of the table later is no part of it.
  EXPECT_EQ(render(0.1, {{"form", "harmonics"}}).counters.skipped.at("parts_loaded"), 3u);
}

TEST_F(TransferFiles, ThatAreStaleAreRefused) {
  render();
  EXPECT_THAT(refusal(0.2), HasSubstr("another shape, material, light or setting"));
  EXPECT_THAT(refusal(0.2), HasSubstr(name()));
  for (const std::map<std::string, std::string>& set : {std::map<std::string, std::string>{{"directions", "81"}},
                                                        {{"max_relative_error", "1e-2"}},
                                                        {{"subdivide", "2"}},
                                                        {{"elements", "discs"}},
                                                        {{"form", "vector"}},
                                                        {{"profile", "better_dipole"}},
                                                        {{"lights", "scene"}}})
    EXPECT_THAT(refusal(0.1, set), HasSubstr("remove it, or name another file")) << set.begin()->first;
  EXPECT_EQ(render().counters.skipped.at("parts_loaded"), 3u) << "a refused file stays as it was";
}

TEST_F(TransferFiles, ThatAreCutShortOrDamagedAreRefused) {
  render();
  const std::string whole = read_file(name());
  for (const std::size_t size : {whole.size() - 1, whole.size() - 40, whole.size() / 2, std::size_t{30}}) {
    write(name(), whole.substr(0, size));
    EXPECT_THAT(refusal(), HasSubstr("is cut short")) << size;
  }
  for (const std::size_t size : {std::size_t{20}, std::size_t{0}}) {
    write(name(), whole.substr(0, size));
    EXPECT_THAT(refusal(), HasSubstr("is not a file of transfer tables")) << size;
  }
  std::string damaged = whole;
  damaged[whole.size() / 2] ^= 1;
  write(name(), damaged);
  EXPECT_THAT(refusal(), HasSubstr("checksum"));
  std::string newer = whole;
  newer[16] = 9;
  write(name(), newer);
  EXPECT_THAT(refusal(), HasSubstr("is of version 9, not 1"));
  write(name(), "something else altogether");
  EXPECT_THAT(refusal(), HasSubstr("is not a file of transfer tables"));
}

TEST_F(TransferFiles, AreTakenUpWhereTheyWereLeft) {
  const Frame made = render();
  const std::string whole = read_file(name());
  const std::size_t head = 24, end = 32, part = (32 * 3 * 162) * 4 + 40;  // floats of 32 nodes, 3 tables, 162 vertices
  ASSERT_EQ(whole.size(), head + end + 2 * part + 16 * 3 * 162 * 4 + 40);
  std::filesystem::remove(name());
  write(name() + ".part", whole.substr(0, head + part + part / 2));  // stopped within the second part
  const Frame again = render();
  EXPECT_EQ(again.counters.skipped.at("parts_loaded"), 1u);
  EXPECT_EQ(again.counters.done.at("parts"), 2u);
  EXPECT_EQ(again.exitance, made.exitance);
  EXPECT_EQ(read_file(name()), whole);
  EXPECT_EQ(folder_.file_count(), 1u);

  std::filesystem::remove(name());
  write(name() + ".part", whole.substr(0, head + part));
  EXPECT_THAT(refusal(0.3), HasSubstr("table.bin.part: was made for another"));
}

TEST_F(TransferFiles, ThatCannotBeWrittenAreAnError) {
  const test::TempFolder none;
  EXPECT_THAT(test::message_of([&] { TransferFile(none.file("missing/table.bin")); }), HasSubstr("cannot be written"));
}

}  // namespace
}  // namespace opaline
