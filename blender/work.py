"""Runs work in a separate thread, with progress and cancellation. It does not access Blender's data, which must not be used in threads."""

import threading


class Work:
    """Runs `function(progress)` in a thread. The progress function `progress(part, done, all)` returns False after cancellation."""

    def __init__(self, function):
        self.part = 0.0
        self.done = self.all = 0
        self._function = function
        self._cancelled = False
        self._result = self._error = self._on_progress = None
        self._thread = threading.Thread(target=self._run, name="isomend", daemon=True)

    def start(self):
        """Starts the thread; returns itself."""
        self._thread.start()
        return self

    def run(self, on_progress=None):
        """Does the work in the calling thread and returns its result. `on_progress(part)` is called with the part done, from 0 to 1."""
        self._on_progress = on_progress
        self._run()
        return self.result()

    def cancel(self):
        """Asks the work to stop, which takes up to a second."""
        self._cancelled = True

    def is_running(self):
        """Whether the thread is running."""
        return self._thread.is_alive()

    def result(self):
        """The result of the function. If the function raised an exception, it is raised here."""
        if self._error is not None:
            raise self._error
        return self._result

    def text(self):
        """The progress as a text for the user."""
        regions = f", region {min(self.done + 1, self.all)} of {self.all}" if self.all > 1 else ""
        return f"isomend: {round(100 * self.part)} %{regions}"

    def _run(self):
        try:
            self._result = self._function(self._progress)
        except BaseException as error:  # Raised again in `result`, in the thread that can report it.
            self._error = error

    def _progress(self, part, done, all_regions):
        self.part, self.done, self.all = part, done, all_regions
        if self._on_progress is not None:
            self._on_progress(part)
        return not self._cancelled
