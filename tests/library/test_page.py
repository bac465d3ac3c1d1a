"""The code of docs/library.md runs."""

import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "library.md"


def test_the_code_of_the_page_runs(tmp_path, monkeypatch, capsys):
    if not PAGE.is_file():
        pytest.skip("the documentation is not here")
    monkeypatch.chdir(tmp_path)
    (block,) = re.findall(r"```python\n(.*?)```", PAGE.read_text(), flags=re.DOTALL)
    exec(compile(block, str(PAGE), "exec"), {})
    assert "['create', 'add 2', 'remove 1']" in capsys.readouterr().out
