"""Runs of work on the active mesh: from the panel in a thread, with progress, until Escape cancels it; from a script until the work is done."""

from dataclasses import dataclass

from .refusals import OnMesh, reason_against
from .taken import Taken
from .work import Work

# Seconds between two updates of the progress during a run.
PAUSE = 0.1

# Events that change the view, which are passed on to Blender during a run.
OF_VIEW = {"MIDDLEMOUSE", "WHEELUPMOUSE", "WHEELDOWNMOUSE", "TRACKPADPAN", "TRACKPADZOOM", "MOUSEROTATE", "MOUSEMOVE"}


@dataclass
class Progress:
    """Progress of a run in a thread, which the panel draws as a bar: the part done, from 0 to 1, negative if none runs, and a text."""

    part: float = -1.0
    text: str = ""


progress = Progress()


class Running(OnMesh):
    """Base class of the operators that work on a mesh. An operator has `work(taken)`, which returns the function to run, and
    `finish(context, item, taken, result)`, which writes and reports what `result()` returns, or raises."""

    # What the status bar says of work that does not tell its progress; such work cannot be stopped, so its result is dropped.
    doing = None

    def prepare(self, context):
        """The mesh as arrays, and the work on it; none, with a message to the user, if the object is refused."""
        reason = reason_against(context.active_object)
        if reason:
            self.report({"ERROR"}, reason)
            return None
        try:
            taken = Taken(context.active_object)
            return taken, Work(self.work(taken))
        except ValueError as error:
            self.report({"ERROR"}, str(error))
            return None

    def execute(self, context):
        """Does the work and returns when it is done."""
        prepared = self.prepare(context)
        if prepared is None:
            return {"CANCELLED"}
        taken, work = prepared
        manager = context.window_manager
        manager.progress_begin(0, 100)
        try:
            return self.finish(context, context.active_object, taken, lambda: work.run(lambda p: manager.progress_update(100 * p)))
        finally:
            manager.progress_end()

    def invoke(self, context, event):
        """Starts the work in a thread."""
        prepared = self.prepare(context)
        if prepared is None:
            return {"CANCELLED"}
        self._taken, work = prepared
        self._item = context.active_object
        self._work = work.start()
        self._timer = context.window_manager.event_timer_add(PAUSE, window=context.window)
        context.window_manager.modal_handler_add(self)
        self.show_progress(context, 0, self.doing or work.text())
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        """Shows the progress of the work, and ends the run when the work is done. Until then only the view can be changed."""
        if event.type == "ESC" and event.value == "PRESS":
            self._work.cancel()
            if self.doing:
                self.clear_progress(context)
                self.report({"WARNING"}, "Cancelled")
                return {"CANCELLED"}
            self.show_progress(context, self._work.part, "isomend: being cancelled")
        if event.type in OF_VIEW:
            return {"PASS_THROUGH"}
        if event.type != "TIMER":
            return {"RUNNING_MODAL"}
        if self._work.is_running():
            self.show_progress(context, self._work.part, f"{self.doing or self._work.text()} (Esc cancels)")
            return {"RUNNING_MODAL"}
        self.clear_progress(context)
        return self.finish(context, self._item, self._taken, self._work.result)

    def cancel(self, context):
        """Called when Blender ends the run, for example to open another file."""
        self._work.cancel()
        self.clear_progress(context)

    def clear_progress(self, context):
        """Removes the display of the progress and the timer."""
        self.show_progress(context, -1, None)
        context.window_manager.event_timer_remove(self._timer)

    def show_progress(self, context, part, text):
        """Shows progress (`part` from 0 to 1, negative for none) in the panel and in the status bar."""
        progress.part, progress.text = part, text or ""
        if context.workspace is not None:
            context.workspace.status_text_set(text)
        if context.screen is not None:
            for area in context.screen.areas:
                if area.type == "VIEW_3D":
                    area.tag_redraw()
