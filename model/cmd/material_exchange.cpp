// `opaline material export` and `import`: the library's or a file's material in other programs' terms, and back.
#include "model/cmd/commands.h"
#include "model/materials/exchange.h"
#include "model/materials/library.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <nlohmann/json.hpp>

#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>

namespace opaline {
namespace {

using Json = nlohmann::ordered_json;

std::string read_text(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) throw std::invalid_argument(path + ": the file cannot be read");
  return {std::istreambuf_iterator<char>(in), {}};
}

/// material.json of a fit, or a material of a scene file.
ExchangeMaterial from_json(const std::string& path) {
  try {
    const Json json = Json::parse(read_text(path));
    ExchangeMaterial m;
    m.sigma_a = json.at("sigma_a_per_mm").get<std::array<double, 3>>();
    m.sigma_s_prime = json.at("sigma_s_prime_per_mm").get<std::array<double, 3>>();
    m.eta = json.at("eta").get<double>();
    m.g = json.value("g", 0.0);
    return m;
  } catch (const Json::exception& error) {
    throw std::invalid_argument(
        path + ": needs sigma_a_per_mm and sigma_s_prime_per_mm (three numbers each) and eta: " + error.what());
  }
}

ExchangeMaterial material_of(const std::string& name) {
  if (name.size() > 5 && name.substr(name.size() - 5) == ".json") return from_json(name);
  const MaterialRow* row = find_material(name);
  if (row == nullptr)
    throw std::invalid_argument(fmt::format("NAME: no material \"{}\"; give a .json file or one of {}", name,
                                            fmt::join(material_names(), ", ")));
  ExchangeMaterial m;
  m.name = row->name;
  for (char& c : m.name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  m.sigma_a = row->sigma_a, m.sigma_s_prime = row->sigma_s_prime, m.eta = row->eta;
  return m;
}

struct Arguments {
  std::string name, format, colour = "van_de_hulst", out;
  double mm_per_unit = 0;
  std::optional<double> g;
};

ExchangeSettings settings_of(const Arguments& a) { return {a.mm_per_unit, parse_colour_meaning(a.colour)}; }

void put(const std::string& text, const std::string& out) {
  if (out.empty()) {
    fmt::print("{}", text);
    return;
  }
  const std::string partial = out + ".part";
  std::ofstream file(partial, std::ios::binary);
  file << text;
  file.close();
  if (!file || std::rename(partial.c_str(), out.c_str()) != 0) throw std::invalid_argument(out + ": cannot be written");
}

void export_material(const Arguments& a) {
  const ExchangeFormat& format = find_exchange_format(a.format);
  ExchangeMaterial m = material_of(a.name);
  if (a.g) m.g = *a.g;
  put(write_material(format, m, settings_of(a)), a.out);
}

void import_material(const Arguments& a) {
  const ExchangeMaterial m = read_material(find_exchange_format(a.format), read_text(a.name), settings_of(a));
  const Json json = {
      {"sigma_a_per_mm", m.sigma_a}, {"sigma_s_prime_per_mm", m.sigma_s_prime}, {"g", m.g}, {"eta", m.eta}};
  put(json.dump(2) + "\n", a.out);
}

std::string list_of_formats() {
  std::string text = "Formats:\n";
  for (const ExchangeFormat& f : exchange_formats())
    text += fmt::format("  {:<17} {}\n{:20}{}\n{:20}Source: {}\n", f.name, f.summary, "", f.convention, "", f.source);
  return text;
}

void add_common(CLI::App& command, Arguments& a) {
  command
      .add_option("--mm-per-unit", a.mm_per_unit,
                  "Length of the other program's scene unit [mm] (default 1; gltf, unity 1000)")
      ->check(CLI::PositiveNumber);
  command
      .add_option("--colour", a.colour,
                  "Meaning of multiple-scattering colour: van_de_hulst (index-matched white sky, what the standards "
                  "suggest) or rendered (what shows behind the real boundary)")
      ->capture_default_str();
  command.add_option("--out", a.out, "File instead of stdout");
}

}  // namespace

void add_material_exchange(CLI::App& material) {
  const auto a = std::make_shared<Arguments>();
  CLI::App* out = material.add_subcommand("export", "A material in another program's terms");
  out->add_option("NAME", a->name, "Name in the library, or a .json file (material.json of a fit)")->required();
  out->add_option("--to", a->format, "Format, see below")->required();
  out->add_option("--g", a->g, "Mean scattering cosine to assume; sigma_s = sigma_s'/(1 - g)")
      ->check(CLI::Range(-0.999, 0.999));
  add_common(*out, *a);
  out->footer(list_of_formats() + "Example: opaline material export skin1 --to openpbr --out skin1.mtlx");
  out->callback([a] { export_material(*a); });
  CLI::App* in = material.add_subcommand("import", "Another program's material as one of a scene file");
  in->add_option("FILE", a->name, "Text with the fields that export writes")->required();
  in->add_option("--from", a->format, "Format, as for export")->required();
  add_common(*in, *a);
  in->footer("Example: opaline material import skin1.mtlx --from openpbr");
  in->callback([a] { import_material(*a); });
}

}  // namespace opaline
