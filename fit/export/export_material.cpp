#include "fit/export/export_material.h"

#include "render/scene/json_object.h"

#include <cctype>
#include <filesystem>

namespace opaline {

ExchangeMaterial exchange_material(const Material& material) {
  ExchangeMaterial m;
  m.name = material.name.empty() ? "opaline" : material.name;
  for (char& c : m.name)
    if (!std::isalnum(static_cast<unsigned char>(c))) c = '_';
  for (int c = 0; c < 3; ++c) {
    m.sigma_a[static_cast<std::size_t>(c)] = material.sigma_a[c];
    m.sigma_s_prime[static_cast<std::size_t>(c)] = material.sigma_s_prime[c];
  }
  m.g = material.g, m.eta = material.eta;
  return m;
}

void write_exports(const Material& material, const std::vector<std::string>& formats, const std::string& directory,
                   std::vector<std::string>& written) {
  for (const std::string& name : formats) {
    const ExchangeFormat& format = find_exchange_format(name);
    const auto path = std::filesystem::path(directory) / ("material_" + name + "." + format.extension);
    write_text_atomically(path.string(), write_material(format, exchange_material(material), {}));
    written.push_back(path.string());
  }
}

}  // namespace opaline
