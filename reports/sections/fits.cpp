// Fits: true against recovered, intervals, convergence, pictures.
#include "reports/fit_table.h"
#include "reports/html.h"
#include "reports/pictures.h"
#include "reports/sections/section.h"

#include <fmt/format.h>

namespace opaline {
namespace {

using nlohmann::json;
constexpr int picture_side = 256;

std::string picture_html(const std::string& name, const std::string& path, const FitResult& fit) {
  try {
    const Image image = shrunk(read_image(path), picture_side),
                target = shrunk(read_image(fit.images.at("target")), picture_side);
    const double level = rms(target);
    const bool signed_error = name == "difference";
    const std::string png = signed_error ? false_colour_png(relative_size(image, target, level > 0 ? level : 1, false))
                                         : tonemapped_png(image, auto_exposure(target));
    return fmt::format(
        "<figure><img src=\"{}\" alt=\"{} of {}\" width=\"{}\" height=\"{}\"><figcaption>{}</figcaption></figure>\n",
        data_uri(png), html_escaped(name), html_escaped(fit.name), image.width, image.height,
        signed_error ? "difference, relative to the target's RMS, on the common scale" : html_escaped(name));
  } catch (const std::exception& error) {
    return fmt::format("<p class=\"muted\">{}</p>\n", html_escaped(error.what()));
  }
}

HtmlFigure pictures(const FitResult& fit) {
  std::string html = "<div class=\"row thumbs\">\n";
  if (fit.images.count("target") == 0) return {"", ""};
  for (const auto& name : {"target", "refit", "difference"})
    if (const auto it = fit.images.find(name); it != fit.images.end()) html += picture_html(name, it->second, fit);
  return {html + "</div>\n", ""};
}

/// Cost histories of all starts; page/plots.js draws them.
HtmlFigure convergence(const FitResult& fit, std::size_t index) {
  nlohmann::ordered_json histories = nlohmann::ordered_json::array();
  for (const json& start : fit.fit.value("start_records", json::array()))
    if (start.is_object() && start.contains("cost_history")) histories.emplace_back(start["cost_history"]);
  if (histories.empty()) return {"<p class=\"muted\">The fit recorded no convergence.</p>\n", ""};
  return {fmt::format(
              "<div class=\"plot small convergence\" id=\"convergence-{0}\" role=\"img\" aria-label=\"Cost of each "
              "start of {1} "
              "against iterations, logarithmic\"></div>\n<script type=\"application/json\" class=\"convergence-data\" "
              "data-plot=\"convergence-{0}\">{2}</script>\n",
              index, html_escaped(fit.name), script_json(histories)),
          ""};
}

Blocks write(const ReportData& data) {
  if (data.fits.empty())
    return {
        Paragraph{"There are no fits: `opaline fit SCENE --target IMAGE --out DIR/fits/NAME` makes one.", Tone::muted}};
  Blocks blocks;
  for (std::size_t i = 0; i < data.fits.size(); ++i) {
    const FitResult& fit = data.fits[i];
    blocks.push_back(Heading{fit.name, ""});
    blocks.push_back(fit_sentence(fit));
    blocks.push_back(fit_table(fit));
    blocks.push_back(convergence(fit, i));
    blocks.push_back(pictures(fit));
    if (const auto notes = fit_notes(fit); !notes.empty()) blocks.push_back(List{notes});
  }
  return blocks;
}

}  // namespace

Section fits_section() { return {"fits", "Fits", write}; }

}  // namespace opaline
