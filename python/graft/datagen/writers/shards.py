"""Tables in several files of bounded size, the last of which grows by being written anew, whole, for each episode."""

from __future__ import annotations

from pathlib import Path

import pyarrow as pa
import pyarrow.compute as pc

from graft.datagen.durable import put
from graft.datagen.writers.tables import parquet_bytes, place, read_parquet


class Shards:
    """The files of a table, and in memory the rows of the last.

    A file that has `limit` bytes in memory is full, and the next begins; so an episode costs at most that much writing,
    and the whole needs no more memory.

    Args:
        root: Of the dataset.
        pattern: Of the paths.
        limit: Bytes.
    """

    def __init__(self, root: Path, pattern: str, limit: int) -> None:
        self._root, self._pattern, self._limit = root, pattern, limit
        self._rows: pa.Table | None = None
        self._bytes = 0
        self.index = 0

    def path(self, index: int) -> Path:
        """Return the path of a file by its running number."""
        return self._root / self._pattern.format(**place(index))

    def files(self) -> list[Path]:
        """Return the files that are there, in order."""
        found: list[Path] = []
        while (path := self.path(len(found))).is_file():
            found.append(path)
        return found

    def resume(self, keep: int) -> None:
        """Go on after the files on disk, dropping rows of episodes from number `keep` on.

        A killed writer may have written the steps of an episode that it did not get to enter.
        """
        files = self.files()
        while files:
            self.index, path = len(files) - 1, files.pop()
            rows = read_parquet(path)
            kept = rows.filter(pc.less(rows["episode_index"], keep))
            if len(kept) == 0:
                path.unlink()
                continue
            if len(kept) < len(rows):
                put(path, parquet_bytes(kept))
            self._turn(kept, kept.nbytes)
            return
        self.index, self._rows, self._bytes = 0, None, 0

    def append(self, rows: pa.Table) -> None:
        """Add the rows of an episode to the last file; nothing changes when the system refuses."""
        # Rows that were read call the items of their lists otherwise than those that were made.
        earlier = [] if self._rows is None else [self._rows.cast(rows.schema)]
        together = pa.concat_tables([*earlier, rows]).combine_chunks()
        put(self.path(self.index), parquet_bytes(together))
        # nbytes of the new rows only: of many chunks it takes longer than writing them.
        self._turn(together, self._bytes + rows.nbytes)

    def _turn(self, rows: pa.Table, size: int) -> None:
        if size >= self._limit:
            self.index, self._rows, self._bytes = self.index + 1, None, 0
        else:
            self._rows, self._bytes = rows, size
