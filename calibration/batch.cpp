// A folder of photographs, one after the other: each already uses every core.
#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <map>
#include <new>

#include "calibration/calibrate.hpp"
#include "platform/host/error.hpp"
#include "platform/host/interrupt.hpp"
#include "platform/host/output_file.hpp"
#include "platform/host/progress.hpp"

namespace aluminate::calibration {
namespace {

namespace fs = std::filesystem;

std::string lower_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](char c) { return static_cast<char>(std::tolower(static_cast<unsigned char>(c))); });
  return text;
}

bool is_picture(const fs::path& path) {
  static constexpr std::array<std::string_view, 14> kEndings{".png", ".jpg", ".jpeg", ".tif", ".tiff",
                                                             ".exr", ".dng", ".cr2",  ".cr3", ".nef",
                                                             ".arw", ".orf", ".rw2",  ".pef"};
  return std::find(kEndings.begin(), kEndings.end(), lower_case(path.extension().string())) != kEndings.end();
}

// wall.jpg becomes wall.png; where wall.jpg and wall.dng are both there, wall.jpg.png and wall.dng.png.
void name_outputs(std::vector<BatchItem>& items, const fs::path& folder, const std::string& ending) {
  std::map<std::string, int> stems;
  for (const BatchItem& item : items) ++stems[lower_case(fs::path(item.photo).stem().string())];
  for (BatchItem& item : items) {
    const fs::path photo(item.photo);
    const bool alone = stems[lower_case(photo.stem().string())] == 1;
    item.output = (folder / ((alone ? photo.stem() : photo.filename()).string() + ending)).string();
  }
}

}  // namespace

std::vector<BatchItem> calibrate_folder(const std::string& folder, const std::string& output_folder,
                                        const std::string& ending, const CalibrationOptions& options,
                                        const std::string& command) {
  std::error_code error;
  if (!fs::is_directory(folder, error))
    throw UserError({folder}, "expected a folder of photographs",
                    "without --batch one photograph is calibrated");
  if (fs::equivalent(folder, output_folder, error))
    throw UserError({output_folder}, "the outputs would lie among the photographs",
                    "give another folder with -o");
  check_output_name("output" + ending, options.format);
  std::vector<BatchItem> items;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder))
    if (entry.is_regular_file(error) && is_picture(entry.path()))
      items.push_back({entry.path().string(), "", std::nullopt, ""});
  if (items.empty()) throw UserError({folder}, "there is no picture in this folder");
  std::sort(items.begin(), items.end(),
            [](const BatchItem& a, const BatchItem& b) { return a.photo < b.photo; });
  name_outputs(items, output_folder, ending);
  host::make_directories(output_folder);
  host::Progress progress("calibrate", static_cast<std::int64_t>(items.size()));
  for (BatchItem& item : items) {
    host::throw_if_interrupted();
    try {
      item.done =
          calibrate(item.photo, options, {item.output, item.output + ".json", "", "", "", ""}, command);
    } catch (const UserError& refusal) {
      item.reason = refusal.what();
    } catch (const std::bad_alloc&) {
      item.reason = item.photo + ": not enough memory";
    }
    progress.advance();
  }
  return items;
}

std::string batch_text(const std::vector<BatchItem>& items) {
  std::string text;
  std::size_t done = 0;
  for (const BatchItem& item : items) {
    done += item.done ? 1 : 0;
    text += item.done ? fmt::format("ok      {}: {}\n", item.photo, verdict_line(*item.done))
                      : fmt::format("refused {}\n", item.reason);
    if (item.done)
      for (const std::string& warning : item.done->warnings) text += fmt::format("        {}\n", warning);
  }
  return text + fmt::format("{} of {} photographs calibrated, {} refused\n", done, items.size(),
                            items.size() - done);
}

}  // namespace aluminate::calibration
