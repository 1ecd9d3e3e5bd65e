"""The scripts people run first: bash in strict mode, executable, with --help, from any folder."""

import os
import pathlib
import subprocess
import tempfile
import unittest

ROOT = pathlib.Path(__file__).resolve().parents[2]
SCRIPTS = ["tools/deps", "tools/demo", "tools/test"]


class Scripts(unittest.TestCase):
    def run_script(self, name, *arguments, environment=None):
        with tempfile.TemporaryDirectory() as elsewhere:
            return subprocess.run([ROOT / name, *arguments], cwd=elsewhere, env=environment, capture_output=True,
                                  text=True, check=False)

    def test_strict_and_executable(self):
        for name in SCRIPTS + [".ci/run"]:
            with self.subTest(name):
                text = (ROOT / name).read_text()
                self.assertTrue(text.startswith("#!/usr/bin/env bash\n"))
                self.assertIn("set -euo pipefail", text)
                self.assertTrue(os.access(ROOT / name, os.X_OK))
                self.assertEqual(subprocess.run(["bash", "-n", ROOT / name], check=False).returncode, 0)

    def test_help_and_unknown_options(self):
        for name in SCRIPTS:
            with self.subTest(name):
                shown = self.run_script(name, "--help")
                self.assertEqual(shown.returncode, 0)
                self.assertTrue(shown.stdout.startswith(f"usage: {name}"))
                refused = self.run_script(name, "--no-such-option")
                self.assertEqual(refused.returncode, 2)
                self.assertIn("unknown option '--no-such-option'", refused.stderr)

    def test_deps_explains_itself_where_there_is_no_apt(self):
        with tempfile.TemporaryDirectory() as folder:
            for tool in ("bash", "env", "cat"):
                os.symlink(f"/usr/bin/{tool}", f"{folder}/{tool}")
            refused = self.run_script("tools/deps", environment={"PATH": folder})
        self.assertEqual(refused.returncode, 1)
        self.assertIn("no Debian system", refused.stderr)
        self.assertIn("libtbb-dev", refused.stderr)

    def test_continuous_integration_is_the_same_as_tools_test(self):
        shown = self.run_script(".ci/run", "--help")
        self.assertTrue(shown.stdout.startswith("usage: tools/test"))


if __name__ == "__main__":
    unittest.main()
