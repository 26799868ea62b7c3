"""The file of rows: made once, or gone on with after a kill."""

import os
import tempfile
import unittest

from webloop.journal import Journal, JournalError


class Files(unittest.TestCase):
    def test_a_second_life_goes_on_behind_what_is_there(self):
        for left, now in [
            (None, "n,x\n9,\n"),
            ("", "n,x\n9,\n"),
            ("n,x\n", "n,x\n9,\n"),
            ("n,x\n1,0.5\n", "n,x\n1,0.5\n9,\n"),
            ("n,x\n1,0.", "n,x\n1,0.\n9,\n"),
        ]:
            self.assertEqual(self._written(left, again=True), now, left)

    def test_what_is_not_to_be_gone_on_with_is_refused_and_kept(self):
        for left, again, why in [
            ("n,x\n", False, "cannot create"),
            ("n,y\n1,\n", True, "its header is not n,x"),
            ("n,", True, "its header is not n,x"),
        ]:
            with self.assertRaises(JournalError) as raised:
                self._written(left, again)
            self.assertIn(why, str(raised.exception))

    def _written(self, left, again):
        """Writes a row to a file in which something was left; what it has then."""
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "rows.csv")
            if left is not None:
                with open(path, "w", encoding="ascii") as file:
                    file.write(left)
            try:
                journal = Journal(path, ("n", "x"), again)
            except JournalError:
                with open(path, encoding="ascii") as file:
                    self.assertEqual(file.read(), left)
                raise
            journal.record("9,\n")
            self.assertEqual(journal.finish(), {"rows": 1, "overflow": 0})
            with open(path, encoding="ascii") as file:
                return file.read()


if __name__ == "__main__":
    unittest.main()
