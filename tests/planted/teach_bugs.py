"""Wrongs that somebody could write in the server of the page, and the test that must notice each."""

from __future__ import annotations

from tests.planted.bug import Bug

DOOR, SESSION, DRAWING = "teach/door.py", "teach/session.py", "teach/drawing.py"
IN_DOOR, IN_SESSION = "teach/test_door.py::test_", "teach/test_session.py::test_"
IN_DRAWING, IN_FILES = "teach/test_drawing.py::test_", "teach/test_files.py::test_"

TEACH_BUGS = [
    Bug("the begin of the token opens the door", DOOR,
        'hmac.compare_digest(token.encode("utf-8", "replace"), self._token.encode())',
        'hmac.compare_digest(token.encode("utf-8", "replace"), self._token[: len(token)].encode())',
        IN_DOOR + "without_the_token_nothing_is_there"),
    Bug("a socket without an origin is let in", DOOR, "and len(origins) != 1", "and len(origins) > 1",
        IN_DOOR + "the_socket_is_closed_to_other_origins_and_to_none"),
    Bug("any port of this machine is an origin", DOOR, 'origin != f"http://{hosts[0]}"',
        'not origin.startswith(f"http://{hosts[0].split(\':\')[0]}")',
        IN_DOOR + "other_origins_get_neither_page_nor_parts"),
    Bug("any address is one of a loopback server", DOOR, "found is not None and found.is_loopback", "found is not None",
        IN_DOOR + "other_names_for_this_machine_are_refused"),
    Bug("parts of the page may be parts of others", DOOR, 'not in ("none", "same-origin")', 'in ("nothing",)',
        IN_DOOR + "parts_are_no_parts_of_other_pages"),
    Bug("what was done is done again", SESSION, "if operation.number == self._last + 1:",
        "if operation.number <= self._last + 1:", IN_SESSION + "what_was_done_is_not_done_again"),
    Bug("what is missing is passed over", SESSION, "if operation.number > self._last + 1:", "if False:",
        IN_SESSION + "a_missing_number_is_asked_for"),
    Bug("points that came too fast count as done", SESSION, "                if isinstance(operation, Points):",
        "                self._last = operation.number\n                if isinstance(operation, Points):",
        IN_SESSION + "points_that_come_too_fast_may_come_again_later"),
    Bug("errors are logged without end", SESSION, "if problem.code not in self._logged:", "if True:",
        IN_SESSION + "each_kind_of_error_is_logged_once_for_a_session"),
    Bug("a page that was replaced still draws", SESSION, "if outbox is not self._outbox:", "if False:",
        IN_SESSION + "what_is_said_after_the_session_went_on_elsewhere_is_refused"),
    Bug("a copied tab takes the session away", "teach/register.py", "session.page != hello.page", "False",
        IN_SESSION + "a_copied_tab_gets_a_session_of_its_own"),
    Bug("numbers that are not finite pass the reading", "teach/messages.py", "parse_constant=_no_number",
        "parse_constant=float", "teach/test_messages.py::test_malformed"),
    Bug("times are not compared with the message before", DRAWING, "(*stroke[-1:], *points)", "points",
        IN_DRAWING + "times_increase_from_message_to_message"),
    Bug("a stroke taken away is still learned from", DRAWING, "self._lineage += 1", "self._lineage += 0",
        "teach/test_live.py::test_a_drawing_that_lost_a_stroke_is_learned_anew"),
    Bug("a point is learned from twice", "teach/live.py", "self._fed += 1", "self._fed += 0",
        "teach/test_live.py::test_points_are_learned_from_as_they_come_each_once"),
    Bug("a project is written over another", "teach/files.py", "folder.mkdir()", "folder.mkdir(exist_ok=True)",
        IN_FILES + "projects_of_one_second_stand_beside_each_other"),
    Bug("frames are taken for seconds", "teach/learning.py", 'RATE if recording.time_unit == "s" else None', "RATE",
        "teach/test_learning.py::test_what_has_no_seconds_is_not_resampled"),
    Bug("pen-up waits for the answer to the open stroke", "teach/learner.py", "asyncio.FIRST_COMPLETED",
        "asyncio.ALL_COMPLETED",
        "teach/test_learner.py::test_pen_up_does_not_wait_for_an_answer_to_the_open_stroke"),
    Bug("an answer to what was cleared is sent", "teach/learner.py", "if same:", "if sheet:",
        "teach/test_learner.py::test_an_answer_to_what_has_changed_since_is_not_said"),
    Bug("an old answer is sent after a newer one waits", "teach/outbox.py", "if kind in NEWEST:", "if False:",
        "teach/test_outbox.py::test_of_answers_and_of_what_is_done_only_the_newest_is_sent"),
]  # fmt: skip
