"""tools/deps installs exactly the libraries that cmake/packages.cmake asks for, and CMake hints name real entries."""

import pathlib
import re
import subprocess
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
PACKAGE_NAME = re.compile(r"^[a-z0-9][a-z0-9+.-]+$")


def asked_for_by_cmake():
    """Debian packages in the second argument of aluminate_need*() and in 'apt-get install' hints."""
    text = re.sub(r"#[^\n]*", "", (ROOT / "cmake/packages.cmake").read_text())
    lists = re.findall(r'aluminate_\w*\([^\s()]+\s+"([^"]*)"', text) + re.findall(r"apt-get install ([^\"$]*)\"", text)
    return {name for packages in lists for name in packages.split()}


def bash_array(name):
    text = (ROOT / "tools/deps").read_text()
    body = re.search(rf"^{name}=\(([^)]*)\)", text, re.MULTILINE)
    return body.group(1).split() if body else []


class Deps(unittest.TestCase):
    def test_lists_are_read(self):
        self.assertIn("libtbb-dev", asked_for_by_cmake())
        self.assertIn("libtbb-dev", bash_array("libraries"))

    def test_same_libraries(self):
        self.assertEqual(sorted(asked_for_by_cmake()), sorted(bash_array("libraries")))

    def test_no_package_twice_and_every_name_plain(self):
        listed = subprocess.run([ROOT / "tools/deps", "--list"], capture_output=True, text=True, check=True).stdout.split()
        self.assertEqual(len(listed), len(set(listed)))
        for name in listed:
            self.assertRegex(name, PACKAGE_NAME)

    def test_tools_that_the_presets_use(self):
        for tool in ("cmake", "ninja-build", "ccache", "g++", "clang", "python3"):
            self.assertIn(tool, bash_array("tools"))


if __name__ == "__main__":
    unittest.main()
