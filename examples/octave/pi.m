## The paper's PI controller for the motor, for GNU Octave without packages.
##
## One request at a time over one connection, at the deadlines start + k h. Deadlines that pass while an answer
## is late are missed, and the integral advances by them too. Octave has no sockets of its own, but bash has:
## this program speaks HTTP through bash's pipes. An answer is given up after 5 s, with its connection.
1;

## Octave would leave a file octave-workspace in the current folder when it is stopped.
sigterm_dumps_octave_core (false);
sighup_dumps_octave_core (false);

## The value of a variable of the environment that is a number.
function value = told (name)
  value = str2double (getenv (name));
  if (isnan (value))
    error ("%s is not a number; start this program by webloop run or webloop conform", name);
  endif
endfunction

## A new connection: a process that copies between its pipes and a socket, until the plant closes that.
function link = connect (host, port)
  relay = "exec 3<>/dev/tcp/$0/$1 4<&0; cat <&4 >&3 & exec cat <&3";
  [link.to, link.from, link.pid] = popen2 ("bash", {"-c", relay, host, port});
endfunction

function disconnect (link)
  kill (link.pid, SIG ().KILL);  # Octave starts it with SIGTERM blocked
  fclose (link.from);
  fclose (link.to);
  waitpid (link.pid);
endfunction

## The body of the answer to a request; empty if the plant refuses it, or none comes within 5 s.
function [body, is_open] = get (link, host, path)
  persistent response = '^HTTP/1\.1 (\d+).*\r\ncontent-length: (\d+)\r\n(?:.+\r\n)?\r\n(.*)$';
  body = text = "";
  is_open = true;
  fputs (link.to, ["GET ", path, " HTTP/1.1\r\nHost: ", host, "\r\n\r\n"]);
  fflush (link.to);
  give_up_s = time () + 5;
  while (time () < give_up_s)
    fclear (link.from);  # a read that found nothing left its mark
    errno (0);
    part = fgets (link.from);
    if (ischar (part))
      text = [text, part];
      found = regexp (text, response, "tokens", "once");
      if (! isempty (found) && numel (found{3}) >= str2double (found{2}))
        if (strcmp (found{1}, "200"))
          body = found{3};
        endif
        return;
      endif
    elseif (errno () == errno_list ().EAGAIN)
      pause (0.0005);
    else
      break;  # the plant has closed the connection
    endif
  endwhile
  is_open = false;
endfunction

sigterm_dumps_octave_core (false);
if (! strcmp (getenv ("WEBLOOP_MODE"), "closed"))
  exit (127);  # an open loop is not supported
endif
[host, port] = strtok (strrep (getenv ("WEBLOOP_PLANT"), "http://", ""), ":");
port = port(2:end);
h = told ("WEBLOOP_H_S");
r = told ("WEBLOOP_R");
start = told ("WEBLOOP_START");  # Octave tells the wall clock alone
duration = told ("WEBLOOP_DURATION_S");

y = 0;  # at rest
link = connect (host, port);
is_open = true;
integral = 0;
k = 0;
passed = 1;
while (true)
  pause (max (0, start + k * h - time ()));
  if (k * h >= duration)
    break;
  endif
  if (! is_open)
    disconnect (link);
    link = connect (host, port);
  endif
  e = r - y;
  integral += 0.378 * (passed * h) * e;
  u = strrep (sprintf ("%.17g", 0.1701 * e + integral), "+", "");
  [body, is_open] = get (link, host, ["/closed?u=", u]);
  found = regexp (body, '&y=([^&]+)', "tokens", "once");
  if (! isempty (found))
    y = str2double (found{1});
  endif
  passed = max (1, floor ((time () - start) / h) - k);
  k += passed;
endwhile
disconnect (link);
exit (0);
