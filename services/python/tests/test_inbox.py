"""Where the loop waits: in order, woken in time, and never for ever."""

import threading
import time
import unittest

from webloop.inbox import Inbox


def within(inbox, seconds):
    """What comes within so many seconds."""
    give_up = time.monotonic() + seconds
    while True:
        inbox.wait(max(give_up - time.monotonic(), 0))
        thing = inbox.take()
        if thing is not None or time.monotonic() > give_up:
            return thing


class Waiting(unittest.TestCase):
    def test_things_come_out_in_order_and_then_there_is_none(self):
        inbox = Inbox()
        for thing in "abc":
            inbox.put(thing)
        self.assertEqual([inbox.take() for _ in range(4)], ["a", "b", "c", None])

    def test_a_short_wait_ends_whenever_it_is_asked(self):
        # What a SimpleQueue of CPython 3.11 does not do within some thousands.
        inbox = Inbox()
        began = time.monotonic()
        for round in range(20_000):
            if round % 3 == 0:
                inbox.put(round)
                self.assertEqual(inbox.take(), round)
            inbox.wait(1e-6)
        self.assertLess(time.monotonic() - began, 60)

    def test_who_waits_is_woken(self):
        inbox = Inbox()
        threading.Timer(0.05, inbox.put, ("here",)).start()
        self.assertEqual(within(inbox, 20), "here")


if __name__ == "__main__":
    unittest.main()
