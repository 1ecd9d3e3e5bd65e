// GIMP plug-in: Colors > Calibrate to albedo. In: the open image, with its ColorChecker marked by a
// path of four clicks (dark skin, bluish green, black, white) or unmarked. Runs `aluminate calibrate` on a
// copy and adds the corrected picture as a layer on top. Never changes the layers that are there; a refusal
// shows the program's reason.
#include <libgimp/gimp.h>

#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

namespace {

constexpr const char* kProcedure = "plug-in-aluminate-calibrate";

// Deleted with what it holds.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    GError* error = nullptr;
    if (gchar* path = g_dir_make_tmp("aluminate-XXXXXX", &error)) {
      path_ = path;
      g_free(path);
    }
    g_clear_error(&error);
  }
  ~TemporaryFolder() {
    std::error_code ignored;
    if (!path_.empty()) std::filesystem::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  std::string file(const char* name) const { return path_ + "/" + name; }
  bool exists() const { return !path_.empty(); }

 private:
  std::string path_;
};

// "x,y;x,y;x,y;x,y" of the active path's four anchors, "" without a path, or an explanation in `problem`.
std::string corners_of_path(gint32 image, std::string& problem) {
  const gint32 path = gimp_image_get_active_vectors(image);
  if (path == -1) return "";
  gint stroke_count = 0;
  gint* strokes = gimp_vectors_get_strokes(path, &stroke_count);
  std::string corners;
  gint anchors = 0;
  for (gint i = 0; i < stroke_count; ++i) {
    gint value_count = 0;
    gdouble* values = nullptr;
    gboolean closed = FALSE;
    gimp_vectors_stroke_get_points(path, strokes[i], &value_count, &values, &closed);
    // A Bezier anchor is six numbers: handle, anchor, handle. GIMP counts from a pixel's corner, aluminate
    // from its centre.
    for (gint at = 0; at + 5 < value_count; at += 6, ++anchors) {
      gchar x[G_ASCII_DTOSTR_BUF_SIZE], y[G_ASCII_DTOSTR_BUF_SIZE];
      corners += (anchors > 0 ? ";" : "") +
                 std::string(g_ascii_formatd(x, sizeof x, "%.3f", values[at + 2] - 0.5)) + "," +
                 g_ascii_formatd(y, sizeof y, "%.3f", values[at + 3] - 0.5);
    }
    g_free(values);
  }
  g_free(strokes);
  if (anchors != 4)
    problem = "the path has " + std::to_string(anchors) +
              " points, expected 4: click dark skin, bluish green, black, white with the Paths tool";
  return corners;
}

// A flat 16-bit copy, saved; the user's image stays as it is.
bool save_copy(gint32 image, const std::string& file) {
  const gint32 copy = gimp_image_duplicate(image);
  gimp_image_undo_disable(copy);
  if (gimp_image_base_type(copy) != GIMP_RGB) gimp_image_convert_rgb(copy);
  if (gimp_image_get_precision(copy) != GIMP_PRECISION_U8_GAMMA &&
      gimp_image_get_precision(copy) != GIMP_PRECISION_U16_GAMMA) {
    gimp_image_convert_precision(copy, GIMP_PRECISION_U16_GAMMA);
  }
  const gint32 layer = gimp_image_flatten(copy);
  const gboolean saved = gimp_file_save(GIMP_RUN_NONINTERACTIVE, copy, layer, file.c_str(), file.c_str());
  gimp_image_delete(copy);
  return saved != FALSE;
}

// True when the program ended with 0; otherwise its last words are in `problem`.
bool run_program(const std::string& program, const std::vector<std::string>& arguments,
                 std::string& problem) {
  std::vector<gchar*> argv{const_cast<gchar*>(program.c_str())};
  for (const std::string& argument : arguments) argv.push_back(const_cast<gchar*>(argument.c_str()));
  argv.push_back(nullptr);
  gchar* talk = nullptr;
  gint status = 0;
  GError* error = nullptr;
  const gboolean started =
      g_spawn_sync(nullptr, argv.data(), nullptr,
                   static_cast<GSpawnFlags>(G_SPAWN_SEARCH_PATH | G_SPAWN_STDOUT_TO_DEV_NULL), nullptr,
                   nullptr, nullptr, &talk, &status, &error);
  if (!started) problem = std::string("cannot start ") + program + ": " + error->message;
  const bool good = started && g_spawn_check_wait_status(status, nullptr);
  if (started && !good) problem = talk != nullptr && *talk != '\0' ? talk : program + " failed";
  g_clear_error(&error);
  g_free(talk);
  return good;
}

std::string calibrate(gint32 image, const std::string& program, const std::string& given_corners,
                      const std::string& fit, gint32& layer) {
  std::string problem;
  const std::string corners = given_corners.empty() ? corners_of_path(image, problem) : given_corners;
  if (!problem.empty()) return problem;
  TemporaryFolder folder;
  if (!folder.exists()) return "cannot make a temporary folder";
  const std::string photo = folder.file("photo.png"), albedo = folder.file("albedo.png");
  if (!save_copy(image, photo)) return "cannot save a copy of the image";
  std::vector<std::string> arguments{"calibrate", photo, "-o", albedo, "--fit", fit};
  if (!corners.empty()) arguments.insert(arguments.end(), {"--corners", corners});
  if (!run_program(program, arguments, problem)) return problem;
  gimp_image_undo_group_start(image);
  layer = gimp_file_load_layer(GIMP_RUN_NONINTERACTIVE, image, albedo.c_str());
  if (layer != -1) {
    gimp_item_set_name(layer, "albedo (aluminate)");
    gimp_image_insert_layer(image, layer, -1, 0);
  }
  gimp_image_undo_group_end(image);
  return layer == -1 ? "cannot load the corrected picture" : "";
}

void query() {
  static const GimpParamDef arguments[] = {
      {GIMP_PDB_INT32, const_cast<gchar*>("run-mode"),
       const_cast<gchar*>("RUN-INTERACTIVE (0) or RUN-NONINTERACTIVE (1)")},
      {GIMP_PDB_IMAGE, const_cast<gchar*>("image"), const_cast<gchar*>("the photograph")},
      {GIMP_PDB_DRAWABLE, const_cast<gchar*>("drawable"),
       const_cast<gchar*>("not used: all visible layers are")},
      {GIMP_PDB_STRING, const_cast<gchar*>("program"),
       const_cast<gchar*>("the aluminate program; empty: on the PATH")},
      {GIMP_PDB_STRING, const_cast<gchar*>("corners"),
       const_cast<gchar*>("x,y;x,y;x,y;x,y; empty: the active path, or found")},
      {GIMP_PDB_STRING, const_cast<gchar*>("fit"), const_cast<gchar*>("as --fit; empty: auto")}};
  static const GimpParamDef results[] = {
      {GIMP_PDB_LAYER, const_cast<gchar*>("layer"), const_cast<gchar*>("the albedo")}};
  gimp_install_procedure(kProcedure, "Correct a photograph with a ColorChecker to diffuse albedo",
                         "Mark the patches dark skin, bluish green, black and white with four clicks of the "
                         "Paths tool, or let the chart be found.",
                         "aluminate", "aluminate", "2026", "Calibrate to _albedo", "*", GIMP_PLUGIN,
                         G_N_ELEMENTS(arguments), G_N_ELEMENTS(results), arguments, results);
  gimp_plugin_menu_register(kProcedure, "<Image>/Colors");
}

std::string text_of(const GimpParam* params, gint count, gint index, const char* otherwise) {
  const bool given =
      index < count && params[index].data.d_string != nullptr && *params[index].data.d_string != '\0';
  return given ? params[index].data.d_string : otherwise;
}

void run(const gchar*, gint count, const GimpParam* params, gint* result_count, GimpParam** results) {
  static GimpParam values[2];
  values[0].type = GIMP_PDB_STATUS;
  values[0].data.d_status = GIMP_PDB_CALLING_ERROR;
  *result_count = 1;
  *results = values;
  if (count < 3) return;
  const bool interactive = params[0].data.d_int32 != GIMP_RUN_NONINTERACTIVE;
  if (interactive) gimp_progress_init("Calibrating to albedo");
  gint32 layer = -1;
  static std::string problem;
  problem = calibrate(params[1].data.d_image, text_of(params, count, 3, "aluminate"),
                      text_of(params, count, 4, ""), text_of(params, count, 5, "auto"), layer);
  *result_count = 2;
  if (!problem.empty()) {
    values[0].data.d_status = GIMP_PDB_EXECUTION_ERROR;
    values[1].type = GIMP_PDB_STRING;
    values[1].data.d_string = problem.data();
    return;
  }
  values[0].data.d_status = GIMP_PDB_SUCCESS;
  values[1].type = GIMP_PDB_LAYER;
  values[1].data.d_layer = layer;
  if (interactive) gimp_displays_flush();
}

}  // namespace

const GimpPlugInInfo PLUG_IN_INFO = {nullptr, nullptr, query, run};

MAIN()
