// aluminate_scenes_make FOLDER: writes the sample scenes into an existing folder.
#include "platform/host/error.hpp"
#include "scenes/generator/sample_models.hpp"

#include <cstdio>

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fputs("usage: aluminate_scenes_make FOLDER\n", stderr);
    return 2;
  }
  try {
    aluminate::scenes::generator::write_samples(argv[1]);
  } catch (const aluminate::UserError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
  return 0;
}
