// Images side by side with a slider, and false-colour errors on one scale. page/viewer.js shows what is embedded here.
#include "reports/gallery.h"
#include "reports/html.h"
#include "reports/pictures.h"
#include "reports/sections/section.h"

#include <fmt/format.h>

namespace opaline {
namespace {

std::string options(const std::vector<GalleryScene>& scenes) {
  std::string text;
  for (std::size_t i = 0; i < scenes.size(); ++i)
    text += fmt::format("<option value=\"{}\">{}</option>", i, html_escaped(scenes[i].title));
  return text;
}

std::string legend() {
  return fmt::format(
      R"(<div class="scale" role="img" aria-label="Colour scale from {0:g} to {1:g} of the reference's RMS, logarithmic">
<div><span>1e-4</span><span>1e-3</span><span>0.01</span><span>0.1</span><span>1</span></div>
<div class="bar" style="background:{2}"></div></div>
)",
      false_colour_low, false_colour_high, false_colour_gradient());
}

std::string viewer_html(const Gallery& gallery) {
  std::string html = fmt::format(R"(<div class="viewer" id="viewer">
<div class="plot-controls">
<label>Scene <select id="viewer-scene">{}</select></label>
<label>Left <select id="viewer-left"></select></label>
<label>Right <select id="viewer-right"></select></label>
<label><input type="checkbox" id="viewer-beside"> side by side</label>
</div>
<div class="row">
<figure class="compare"><div class="stage" id="viewer-stage"><img id="viewer-image-right" alt=""><img id="viewer-image-left" alt=""><div class="handle" id="viewer-handle" aria-hidden="true"></div></div>
<input type="range" id="viewer-slider" min="0" max="100" value="50" aria-label="Part of the left image that is shown, percent">
<figcaption id="viewer-caption" aria-live="polite"></figcaption></figure>
<figure><img id="viewer-error" alt=""><figcaption id="viewer-error-caption"></figcaption></figure>
</div>
{}<noscript><p>The image viewer needs JavaScript.</p></noscript></div>
)",
                                 options(gallery.scenes), legend());
  for (std::size_t i = 0; i < gallery.scenes.size(); ++i)
    html += fmt::format("<script type=\"application/json\" id=\"gallery-{}\">{}</script>\n", i,
                        script_json(gallery.scenes[i].json));
  return html;
}

Blocks write(const ReportData& data) {
  const Gallery gallery = make_gallery(data);
  Blocks blocks;
  if (gallery.scenes.empty())
    blocks.push_back(Paragraph{"No record names an image: the suite keeps none.", Tone::muted});
  else
    blocks.push_back(HtmlFigure{viewer_html(gallery), "The images are in the HTML report."});
  if (!gallery.scenes.empty())
    blocks.push_back(
        Paragraph{"Both images have the exposure of the scene's reference. Errors, bounds and standard errors of all "
                  "scenes share "
                  "the colour scale: RMS over R, G and B per pixel, relative to the RMS of the scene's reference. " +
                      gallery.size_note,
                  Tone::muted});
  if (!gallery.problems.empty()) blocks.push_back(List{gallery.problems});
  return blocks;
}

}  // namespace

Section images_section() { return {"images", "Images", write}; }

}  // namespace opaline
