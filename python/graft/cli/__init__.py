"""The command line: one verb per stage, each a frozen dataclass that tyro turns into flags.

A verb's module is imported only when the verb is called, so that `graft --help` stays fast.
Exit codes: 0 ok, 1 an object has no result (no grasp), 2 usage, 3 bad input, 130 interrupted.
"""

from __future__ import annotations

import importlib
import os
import sys
import warnings
from typing import TextIO

EXIT_OK, EXIT_FAILED, EXIT_USAGE, EXIT_BAD_INPUT, EXIT_INTERRUPTED = 0, 1, 2, 3, 130

VERBS = {
    "demo": ("Demo", "Transfer contacts from demonstrated objects to unseen ones; pictures, page, JSON."),
    "show": ("Show", "Read an object and print its parts; --out writes a picture, page or GLB."),
    "segment": ("Segment", "Cut a fused mesh or point cloud into parts; --out writes a picture, page, GLB or PLY."),
    "match": ("MatchCommand", "Match one object against another and print the transport plan."),
    "transfer": ("TransferCommand", "Transfer a contact from a library of demonstrations to an object."),
    "grasp": ("GraspCommand", "Plan grasps of an object near a contact, on a part, or anywhere."),
    "simulate": ("Simulate", "Try grasps of an object in physics; pictures, films, JSON."),
    "demonstrate": ("Demonstrate", "Make demonstrations by script, in physics, as a library to generate from."),
    "generate": ("Generate", "Replay demonstrations on other objects and keep what succeeds as training data."),
    "replay": ("Replay", "Run episodes again from their own file; check states and outcome."),
    "export": ("Export", "Copy episodes between robomimic's HDF5 and LeRobot datasets."),
    "library": ("LibraryCommand", "Keep demonstrations on disk: build, add, ls, show, verify, compact, export ..."),
    "evaluate": ("Evaluate", "Measure: affordance, ablation, diversity, segmentation, simulation, generation."),
}
"""Verb -> (class in graft.cli.<verb>, one line of help)."""


def usage() -> str:
    """Return the text of `graft --help`."""
    width = max(map(len, VERBS))
    verbs = "\n".join(f"  {verb:<{width}}  {line}" for verb, (_, line) in VERBS.items())
    return (
        "usage: graft VERB ...\n\nA grasp on an object never seen, from one demonstration on another object.\n\n"
        f"verbs:\n{verbs}\n\noptions:\n  -h, --help  this help; `graft VERB --help` for a verb's flags\n"
        "  --version   the version\n"
    )


def main(arguments: list[str] | None = None) -> int:
    """Run the command line and return its exit code; never shows a traceback for a user's mistake."""
    arguments = sys.argv[1:] if arguments is None else arguments
    if len(arguments) > 1 and arguments[0] == "help":
        arguments = [arguments[1], "--help"]
    if not arguments or arguments[0] in ("-h", "--help", "help"):
        print(usage(), end="")
        return EXIT_OK if arguments else EXIT_USAGE
    verb, *rest = arguments
    if verb == "--version":
        from graft import __version__

        print(f"graft {__version__}")
        return EXIT_OK
    if verb not in VERBS:
        return _unknown(verb)
    try:
        code = _run(verb, rest)
        sys.stdout.flush()
        return code
    except KeyboardInterrupt:
        print("graft: interrupted", file=sys.stderr)
        return EXIT_INTERRUPTED
    except BrokenPipeError:
        # The reader of our output went away (`graft show x | head`); Python's flush at exit must not fail, too.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return EXIT_OK


def _unknown(verb: str) -> int:
    import difflib

    close = difflib.get_close_matches(verb, VERBS, n=1)
    hint = f", did you mean {close[0]!r}?" if close else "."
    print(f"graft: no verb {verb!r}{hint} The verbs are {', '.join(VERBS)}.", file=sys.stderr)
    return EXIT_USAGE


def _run(verb: str, rest: list[str]) -> int:
    import tyro

    from graft.errors import GraftError, printable

    command_class = getattr(importlib.import_module(f"graft.cli.{verb}"), VERBS[verb][0])
    with warnings.catch_warnings():
        warnings.simplefilter("default")
        warnings.showwarning = _show_warning
        try:
            command = tyro.cli(command_class, prog=f"graft {verb}", args=rest)
            code: int = command.run()
        except SystemExit as stop:  # tyro has printed what is wrong, or the help
            return EXIT_OK if stop.code in (0, None) else EXIT_USAGE
        except GraftError as error:
            print(f"graft: {error}", file=sys.stderr)
            return EXIT_BAD_INPUT
        except BrokenPipeError:
            raise
        except OSError as error:
            where = f"{error.filename}: " if error.filename else ""
            print(f"graft: {printable(f'{where}{error.strerror or error}')}", file=sys.stderr)
            return EXIT_BAD_INPUT
    return code


def _show_warning(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    file: TextIO | None = None,
    line: str | None = None,
) -> None:
    """Print a warning as one line, without the line of code that noticed it."""
    from graft.errors import InputWarning, printable

    if issubclass(category, InputWarning):
        print(f"graft: warning: {printable(str(message))}", file=sys.stderr)
