## The paper's PI controller for the motor, for GNU Octave without packages.
##
## A request at a time, at the deadlines start + k h. Deadlines that pass while an answer is late are
## skipped, and the integral advances by them too. Its limits are those of urlread:
## - It opens a connection for each message, which takes a round trip more. `webloop conform` says so.
## - It has no time limit. An answer that does not come is waited for as long as TCP waits, and SIGTERM
##   is not heeded before that.
1;

## The output that the plant answers; y if it answers none.
function y = output (url, y)
  [text, is_answered] = urlread (url);
  found = regexp (text, "&y=([^&]+)", "tokens", "once");
  if (is_answered && ! isempty (found))
    y = str2double (found{1});
  endif
endfunction

## The value of a variable of the environment that is a number.
function value = told (name)
  value = str2double (getenv (name));
  if (isnan (value))
    error ("%s is not a number; start this program by webloop run or webloop conform", name);
  endif
endfunction

sigterm_dumps_octave_core (false);
if (! strcmp (getenv ("WEBLOOP_MODE"), "closed"))
  exit (127);  # an open loop is not supported
endif
plant = getenv ("WEBLOOP_PLANT");
h = told ("WEBLOOP_H_S");
r = told ("WEBLOOP_R");
start = told ("WEBLOOP_START");  # Octave tells the wall clock alone
duration = told ("WEBLOOP_DURATION_S");

y = 0;  # at rest
if (time () < start - 0.5)
  y = output ([plant, "/state"], y);
endif
integral = 0;
k = 0;
passed = 1;
while (true)
  pause (max (0, start + k * h - time ()));
  if (k * h >= duration)
    break;
  endif
  e = r - y;
  integral += 0.378 * (passed * h) * e;
  u = strrep (sprintf ("%.17g", 0.1701 * e + integral), "+", "");
  y = output ([plant, "/closed?u=", u], y);
  passed = max (1, floor ((time () - start) / h) - k);
  k += passed;
endwhile
exit (0);
