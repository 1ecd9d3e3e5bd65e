#include "shading/report/difference_page.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "platform/host/error.hpp"
#include "platform/host/image_file.hpp"
#include "shading/report/heat_map.hpp"
#include "shading/report/statistics.hpp"

namespace aluminate::report {
namespace {

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    switch (c) {
      case '&':
        out += "&amp;";
        break;
      case '<':
        out += "&lt;";
        break;
      case '>':
        out += "&gt;";
        break;
      case '"':
        out += "&quot;";
        break;
      default:
        out += c;
    }
  }
  return out;
}

std::string picture_data(int width, int height, std::span<const std::uint8_t> rgba) {
  return "data:image/png;base64," + base64(host::encode_png({width, height, 4, {rgba.begin(), rgba.end()}}));
}

constexpr const char* kStyle = R"(<style>
:root { color-scheme: light dark; font: 15px/1.5 system-ui, sans-serif; }
body { margin: 1.2rem; }
pre, output { font: 13px/1.4 ui-monospace, monospace; }
.stage { position: relative; display: inline-block; overflow: auto; max-width: 100%; border: 1px solid #8888; }
.stage img { display: block; image-rendering: pixelated; }
.stage .over { position: absolute; left: 0; top: 0; }
button[aria-pressed=true] { outline: 2px solid #38f; }
label { margin-right: 1rem; }
@media print { .controls { display: none; } }
</style>)";

// A and B stay exact: canvases are only read, never scaled.
constexpr const char* kScript = R"(<script>
'use strict';
const $ = id => document.getElementById(id);
const a = $('a'), b = $('b'), d = $('d');
let mode = 'slider', zoom = 1, timer = 0;
const texels = image => {
  const canvas = document.createElement('canvas');
  canvas.width = image.naturalWidth; canvas.height = image.naturalHeight;
  const context = canvas.getContext('2d', { willReadFrequently: true });
  context.drawImage(image, 0, 0);
  return context.getImageData(0, 0, canvas.width, canvas.height).data;
};
let ta, tb;
const show = () => {
  clearInterval(timer);
  for (const button of document.querySelectorAll('button[data-mode]')) button.setAttribute('aria-pressed', button.dataset.mode === mode);
  for (const image of [a, b, d]) { image.style.width = a.naturalWidth * zoom + 'px'; image.style.clipPath = ''; }
  d.style.visibility = mode === 'difference' ? 'visible' : 'hidden';
  b.style.visibility = mode === 'a' || mode === 'difference' ? 'hidden' : 'visible';
  $('slide').disabled = mode !== 'slider';
  if (mode === 'slider') b.style.clipPath = `inset(0 0 0 ${$('slide').value}%)`;
  if (mode === 'blink') timer = setInterval(() => { b.style.visibility = b.style.visibility === 'hidden' ? 'visible' : 'hidden'; }, 500);
};
for (const button of document.querySelectorAll('button[data-mode]')) button.onclick = () => { mode = button.dataset.mode; show(); };
$('slide').oninput = show;
$('zoom').onchange = () => { zoom = +$('zoom').value; show(); };
document.onkeydown = event => {
  if (event.key !== ' ' || event.target.tagName === 'BUTTON' || event.target.tagName === 'SELECT') return;
  mode = mode === 'blink' ? 'slider' : 'blink'; show(); event.preventDefault();
};
$('stage').onpointermove = event => {
  ta ??= texels(a); tb ??= texels(b);
  const box = a.getBoundingClientRect();
  const x = Math.floor((event.clientX - box.left) / zoom), y = Math.floor((event.clientY - box.top) / zoom);
  if (x < 0 || y < 0 || x >= a.naturalWidth || y >= a.naturalHeight) return;
  const at = (y * a.naturalWidth + x) * 4, of = t => [...t.slice(at, at + 3)].map(v => String(v).padStart(3)).join(' ');
  $('value').textContent = `(${x}, ${y})  ${a.alt} ${of(ta)}   ${b.alt} ${of(tb)}   of 255`;
};
addEventListener('load', show);
</script>)";

}  // namespace

std::string base64(std::span<const std::uint8_t> bytes) {
  constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  text.reserve((bytes.size() + 2) / 3 * 4);
  for (std::size_t i = 0; i < bytes.size(); i += 3) {
    const std::size_t left = std::min<std::size_t>(3, bytes.size() - i);
    std::uint32_t group = std::uint32_t{bytes[i]} << 16;
    if (left > 1) group |= std::uint32_t{bytes[i + 1]} << 8;
    if (left > 2) group |= bytes[i + 2];
    text += kDigits[group >> 18];
    text += kDigits[group >> 12 & 63];
    text += left > 1 ? kDigits[group >> 6 & 63] : '=';
    text += left > 2 ? kDigits[group & 63] : '=';
  }
  return text;
}

std::string difference_page(const DifferencePage& page) {
  const std::size_t bytes = static_cast<std::size_t>(page.width) * static_cast<std::size_t>(page.height) * 4;
  ALU_CHECK(page.a.size() == bytes && page.b.size() == bytes, "{}x{}, {} and {} bytes", page.width,
            page.height, page.a.size(), page.b.size());
  const ImageDifference difference = compare_images(page.width, page.a, page.b);
  const int gain = difference.p99_step > 0 ? std::max(1, 255 / difference.p99_step) : 1;
  const host::Image8 map = difference_image(page.width, page.height, page.a, page.b, gain);
  std::string text = fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><title>{0}: "
      "difference</title>\n{1}</head>\n"
      "<body>\n<h1>{0}</h1>\n<pre>{2}</pre>\n",
      escaped(page.title), kStyle, escaped(difference_text(difference, page.width, page.a, page.b)));
  text += fmt::format(
      "<p class=\"controls\"><button data-mode=\"slider\">slider</button> <button "
      "data-mode=\"a\">{0}</button> "
      "<button data-mode=\"b\">{1}</button> <button data-mode=\"blink\">blink (space)</button> "
      "<button data-mode=\"difference\">difference x{2}</button>\n"
      "<label>{0} | {1} <input id=\"slide\" type=\"range\" min=\"0\" max=\"100\" value=\"50\"></label>"
      "<label>zoom <select id=\"zoom\"><option>1<option>2<option>4<option>8<option>16</select></label></p>\n"
      "<div class=\"stage\" id=\"stage\"><img id=\"a\" alt=\"{0}\" src=\"{3}\">"
      "<img id=\"b\" class=\"over\" alt=\"{1}\" src=\"{4}\">"
      "<img id=\"d\" class=\"over\" alt=\"absolute difference times {2}\" src=\"{5}\"></div>\n"
      "<p><output id=\"value\">point at the picture for values</output></p>\n",
      escaped(page.name_a), escaped(page.name_b), gain, picture_data(page.width, page.height, page.a),
      picture_data(page.width, page.height, page.b),
      "data:image/png;base64," + base64(host::encode_png(map)));
  if (!page.command.empty())
    text += fmt::format("<p>{} again:</p>\n<pre>{}</pre>\n", escaped(page.name_b), escaped(page.command));
  if (!page.accept.empty())
    text += fmt::format("<p>accept {}:</p>\n<pre>{}</pre>\n", escaped(page.name_b), escaped(page.accept));
  return text + kScript + "\n</body></html>\n";
}

}  // namespace aluminate::report
