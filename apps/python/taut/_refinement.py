"""A frame that is rendered in steps."""

from __future__ import annotations

import os
from typing import Any, Callable, Iterator, Optional, Union

from . import _taut
from ._checks import describe, fail, number, text, whole
from ._picture import Picture


class Refinement:
    """One frame, rendered in steps. Made by Scene.refine, of which only the latest may go on."""

    def __init__(self, core: Any, every: float, settings: _taut.ImageSettings) -> None:
        self._core: _taut.Refinement = core
        self._settings = settings
        self._every = every
        self._stopped = False

    def advance(self, samples: int = 0, seconds: Optional[float] = None, progress: Optional[Callable[[float], Any]] = None) -> str:
        """Renders on: by `samples` more for every pixel, or about `seconds`; to the end where neither is given.

        Returns "going", "stopped" or "done". `progress` as in Scene.render. Ctrl-C raises KeyboardInterrupt within a tile; what the
        picture has is whole, and advance goes on from there.
        """
        if progress is not None and not callable(progress):
            fail("progress", describe(progress), "a function of the share done")
        most = 0.0 if seconds is None else number("seconds", seconds, 0, 1e12, "a time above 0")
        return self._core.advance(whole("samples", samples, 0, 1 << 24), most, progress)

    def picture(self) -> Picture:
        """The frame as it stands, as Scene.render returns it; from any thread, while another advances too."""
        return self._picture(False)

    def _picture(self, denoise: bool) -> Picture:
        pixels, channels, samples, metadata = self._core.denoised() if denoise else self._core.film()
        picture = Picture(pixels, channels, samples)
        picture.metadata = dict(metadata)
        picture.settings = self._settings
        return picture

    def __iter__(self) -> Iterator[Picture]:
        while not self.done and not self._stopped:
            if self.advance(seconds=self._every) == "stopped":
                self._stopped = True
            yield self.picture()

    def stop(self) -> None:
        """Ends what goes on in another thread, within a tile; iteration ends after one more picture."""
        self._stopped = True
        self._core.stop()

    @property
    def done(self) -> bool:
        """Whether all samples are there."""
        return self._core.done

    @property
    def share(self) -> float:
        """Share of the samples that are done, [0, 1]."""
        return self._core.share

    def save(self, path: Union[str, "os.PathLike[str]"]) -> None:
        """A checkpoint: all that `restore` needs to go on, in another process too."""
        self._core.save(text("path", path))

    def restore(self, path: Union[str, "os.PathLike[str]"]) -> "Refinement":
        """Goes on from a checkpoint of the same frame and options (spp may be higher). Raises InputError saying what differs or is
        damaged, and leaves things as they were."""
        self._core.restore(text("path", path))
        return self

    def __repr__(self) -> str:
        return f"<taut.Refinement, {100 * self.share:.0f} % done>"
