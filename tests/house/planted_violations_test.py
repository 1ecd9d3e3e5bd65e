"""Every rule of tools/check_*.py catches a violation planted in a small tree of its own, and lets the clean tree pass."""

import pathlib
import subprocess
import sys
import tempfile
import unittest

TOOLS = pathlib.Path(__file__).resolve().parents[2] / "tools"

# The smallest tree that all three checks accept.
CLEAN = {
    "cmake/packages.cmake": 'aluminate_need(TBB "libtbb-dev")\n',
    "docs/references.md": "# References\n\n- [MSD] Shader model 3 reference.\n- [Schlick94] C. Schlick, 1994.\n",
    "platform/host/error.hpp": "#pragma once\n#include <fmt/format.h>\n#include <string>\n",
    "platform/host/parallel.cpp": "#include <sched.h>\n#include <tbb/parallel_for.h>\n",
    "platform/console/xenos.toml": 'lanes = { value = 48, source = "MSD" }\n',
    "rasterizer/edge.hpp": '#pragma once\n#include "platform/host/error.hpp"\n#include <cmath>\n',
    "rasterizer/edge.cpp": '#include "rasterizer/edge.hpp"\nauto f(double x) { return std::fma(x, x, std::sqrt(x)); }\n',
    "shading/brdf/fresnel.hpp": "#pragma once\n// [Schlick94 eq.15] over values[Index]\n#include <glm/glm.hpp>\n",
    "shading/vm/program.hpp": '#pragma once\n#include "platform/host/error.hpp"\n',
}


def words(*pieces):
    """Joins what must not stand in this file as one word."""
    return "".join(pieces)


class Planted(unittest.TestCase):
    def run_check(self, check, planted):
        with tempfile.TemporaryDirectory() as folder:
            for name, text in {**CLEAN, **planted}.items():
                path = pathlib.Path(folder) / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text)
            done = subprocess.run([sys.executable, "-B", TOOLS / f"check_{check}.py", "--root", folder],
                                  capture_output=True, text=True, check=False)
            return done.returncode, done.stdout + done.stderr

    def catches(self, check, planted, *expected):
        code, text = self.run_check(check, planted)
        self.assertEqual(code, 1, text)
        for part in expected:
            self.assertIn(part, text)

    def accepts(self, check, planted):
        code, text = self.run_check(check, planted)
        self.assertEqual(code, 0, text)

    def test_clean_tree_passes(self):
        for check in ("layers", "citations", "house"):
            with self.subTest(check):
                self.accepts(check, {})


class Layers(Planted):
    def test_upward_include(self):
        self.catches("layers", {"shading/vm/bad.cpp": '#include "rasterizer/edge.hpp"\n'},
                     "shading/vm/bad.cpp:1", "shading/vm must not include rasterizer")
        self.catches("layers", {"shading/brdf/bad.hpp": '#pragma once\n#include "shading/vm/program.hpp"\n'},
                     "shading/brdf must not include shading/vm")
        self.catches("layers", {"platform/number/bad.hpp": '#pragma once\n#include "platform/host/error.hpp"\n'},
                     "platform/number must not include platform/host")
        self.catches("layers", {"rasterizer/bad.cpp": '#include "shading/passes/x.hpp"\n',
                                "shading/passes/x.hpp": "#pragma once\n"}, "rasterizer must not include shading/passes")

    def test_third_party_outside_its_file(self):
        for header in ("OpenImageIO/imageio.h", "tbb/tbb.h", "spdlog/spdlog.h", "xxhash.h", "tiny_gltf.h",
                       "CLI/CLI.hpp", "glm/glm.hpp", "toml++/toml.h", "glslang/Public/ShaderLang.h", "gtest/gtest.h"):
            with self.subTest(header):
                self.catches("layers", {"rasterizer/bad.cpp": f"#include <{header}>\n"}, header, "allowed only in")

    def test_fmt_in_a_public_header(self):
        self.catches("layers", {"scenes/bad.hpp": "#pragma once\n#include <fmt/format.h>\n"}, "fmt/format.h")

    def test_unknown_header(self):
        self.catches("layers", {"apps/bad.cpp": "#include <boost/any.hpp>\n"}, "in no table")

    def test_system_header_above_host(self):
        self.catches("layers", {"scenes/bad.cpp": "#include <unistd.h>\n"}, "belongs in platform/host")

    def test_file_not_in_the_tree(self):
        self.catches("layers", {"rasterizer/bad.cpp": '#include "edge.hpp"\n'}, "written from the root")

    def test_cycle(self):
        self.catches("layers", {"rasterizer/a.hpp": '#pragma once\n#include "rasterizer/b.hpp"\n',
                                "rasterizer/b.hpp": '#pragma once\n#include "rasterizer/a.hpp"\n'},
                     "include cycle: rasterizer/a.hpp -> rasterizer/b.hpp -> rasterizer/a.hpp")

    def test_folder_without_a_room(self):
        self.catches("layers", {"physics/a.cpp": "int a;\n"}, "no room")

    def test_comments_and_strings_are_no_includes(self):
        self.accepts("layers", {"shading/vm/ok.cpp": '// #include "rasterizer/edge.hpp"\n/*\n#include <tbb/tbb.h>\n*/\n'
                                                      'auto s = R"(\n#include <glm/glm.hpp>\n)";\n'})


class Citations(Planted):
    def test_unknown_key(self):
        for text in ("// [Nobody99]\n", "int a; /* see [Nobody99 s.3] */\n", "// [MSD, Nobody99]\n"):
            with self.subTest(text):
                self.catches("citations", {"scenes/bad.cpp": text}, "[Nobody99] is not in")

    def test_key_without_a_digit(self):
        self.catches("citations", {"scenes/bad.cpp": "// [NOBODY]\n"}, "[NOBODY]")

    def test_unknown_source_in_a_platform_file(self):
        self.catches("citations", {"platform/console/bad.toml": 'a = { value = 1, source = "MSD; NOONE" }\n'}, "[NOONE]")

    def test_shader_comments_count(self):
        self.catches("citations", {"shading/programs/bad.hlsl": "float f; // [Nobody99]\n"}, "bad.hlsl:1", "[Nobody99]")

    def test_unused_and_double_entries(self):
        listing = CLEAN["docs/references.md"] + "- [Unused01] Nobody cites it.\n- [MSD] Again.\n"
        self.catches("citations", {"docs/references.md": listing}, "[Unused01] is cited nowhere", "[MSD] is listed twice",
                     "not in alphabetical order")

    def test_listed_key_in_lower_case(self):
        listing = "- [glTF2] Khronos.\n" + CLEAN["docs/references.md"]
        self.catches("citations", {"docs/references.md": listing}, "[glTF2] is cited nowhere")
        self.accepts("citations", {"docs/references.md": listing, "scenes/ok.cpp": "// [glTF2 appendix B], [doc]\n"})

    def test_code_is_no_citation(self):
        self.accepts("citations", {"scenes/ok.cpp": 'int x = table[Index]; auto s = "[NAME]"; [[nodiscard]] int y();\n'
                                                    "// regs[Count] and args()[Count] and [lower] and [A]\n"})

    def test_links_in_documents_are_no_citations(self):
        self.accepts("citations", {"docs/a.md": "[Read this](a.md) and `table[NAME] [NAME]` [Schlick94]\n"})

    def test_missing_list(self):
        self.catches("citations", {"docs/references.md": "nothing\n"}, "found none")


class House(Planted):
    def test_long_files(self):
        self.catches("house", {"scenes/long.cpp": "int a;\n" * 801}, "801 lines, the limit is 800")
        self.accepts("house", {"scenes/tables_generated.cpp": "int a;\n" * 801})
        code, text = self.run_check("house", {"scenes/longish.cpp": "int a;\n" * 501})
        self.assertEqual(code, 0)
        self.assertIn("warning: scenes/longish.cpp: 501 lines", text)

    def test_folder_names(self):
        for folder in ("utils", "common", "scenes/misc", "shading/helpers"):
            with self.subTest(folder):
                self.catches("house", {f"{folder}/a.txt": "x\n"}, "no name for a folder")

    def test_words(self):
        for word in (words("TO", "DO"), words("FIX", "ME"), words("XX", "X"), words("HA", "CK")):
            with self.subTest(word):
                self.catches("house", {"docs/a.md": f"first\n{word}: later\n"}, "docs/a.md:2", word)
        self.accepts("house", {"docs/a.md": words("TO", "DOs") + " and hackneyed\n"})

    def test_machine_paths(self):
        for path in (words("/wor", "k/main"), words("/ro", "ot"), words("/tm", "p/x"), words("/ho", "me/me")):
            with self.subTest(path):
                self.catches("house", {"scenes/bad.cpp": f'auto p = "{path}";\n'}, "exists on one machine only")
        self.accepts("house", {"docs/a.md": "a/work item, docs/tmp-files, w*h/work\n"})

    def test_includes(self):
        for header in ("iostream", "math.h", "immintrin.h"):
            with self.subTest(header):
                self.catches("house", {"apps/bad.cpp": f"#include <{header}>\n"}, header)

    def test_random_numbers(self):
        for code in ("int a = rand();", "srand(1);", "std::random_device d;", "std::uniform_int_distribution<int> d;"):
            with self.subTest(code):
                self.catches("house", {"scenes/bad.cpp": code + "\n"}, "other numbers")
        self.accepts("house", {"scenes/ok.cpp": "int b = operand(3) + x.rand();  // rand()\n"})

    def test_inexact_functions_where_pixels_are_made(self):
        for name in ("rasterizer/bad.cpp", "shading/vm/bad.hpp", "platform/number/bad.cpp"):
            with self.subTest(name):
                self.catches("house", {name: "#pragma once\nauto a = std::exp2(1.0);\n"}, "correctly rounded")
        self.catches("house", {"rasterizer/bad.cpp": "using std::sin;\n"}, "std::sin")
        self.catches("house", {"rasterizer/bad.cpp": "auto a = ::pow(2.0, 3.0);\n"}, "::pow")
        self.accepts("house", {"shading/sky/ok.cpp": "auto a = std::exp2(1.0);\n",
                               "shading/vm/ok.cpp": "auto a = number::exp2(1); auto b = vm::log2(x);\n"})

    def test_namespace_std_and_pragma(self):
        self.catches("house", {"apps/bad.cpp": "using namespace std;\n"}, "using namespace std")
        self.catches("house", {"apps/bad.hpp": "int a;\n"}, "#pragma once")

    def test_packages_are_looked_up_in_one_place(self):
        self.catches("house", {"apps/CMakeLists.txt": "find_package(Boost REQUIRED)\n"}, "Boost is not looked for")
        self.accepts("house", {"apps/CMakeLists.txt": "find_package(Threads)\nfind_package(TBB)\n# find_package(Boost)\n"})


if __name__ == "__main__":
    unittest.main()
