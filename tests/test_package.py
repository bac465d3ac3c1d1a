"""The public surface: every exported name exists, and importing graft stays cheap."""

import subprocess
import sys

import graft


def test_every_exported_name_exists():
    assert sorted(graft.__all__) == sorted(graft._HOMES)
    for name in graft.__all__:
        assert getattr(graft, name) is not None
        assert name in dir(graft)


def test_importing_graft_imports_nothing_heavy():
    code = "import sys, graft; sys.exit(bool({'numpy', 'scipy', 'trimesh', 'mujoco'} & set(sys.modules)))"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
