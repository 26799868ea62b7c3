//! A plant by script that answers commands over HTTP as its test says: it shows itself at rest, and gives each
//! command's query to the test.

use std::{
    io::{BufRead, BufReader, Write},
    net::{SocketAddr, TcpListener, TcpStream},
    sync::Arc,
    thread,
};

/// The answer to a command, by its query; `None` to stay silent.
type Answer = dyn Fn(&str) -> Option<String> + Send + Sync;

/// A plant that answers so, for as long as the test's process lives.
pub(crate) fn plant(answer: impl Fn(&str) -> Option<String> + Send + Sync + 'static) -> SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
    let address = listener.local_addr().expect("bound");
    let answer: Arc<Answer> = Arc::new(answer);
    thread::spawn(move || {
        for stream in listener.incoming().map_while(Result::ok) {
            stream.set_nodelay(true).expect("a socket");
            let answer = Arc::clone(&answer);
            thread::spawn(move || serve(stream, &*answer));
        }
    });
    address
}

/// Answers the requests of one connection.
fn serve(stream: TcpStream, answer: &Answer) {
    let mut out = stream.try_clone().expect("a socket");
    let mut say = |body: &str| {
        let text = format!(
            "HTTP/1.1 200 OK\r\nContent-Length: {}\r\n\r\n{body}",
            body.len()
        );
        // The controller may have given up.
        let _ = out.write_all(text.as_bytes());
    };
    for line in BufReader::new(stream).lines().map_while(Result::ok) {
        let Some(target) = line.strip_prefix("GET ") else {
            continue;
        };
        let target = target.split(' ').next().unwrap_or_default();
        match target.split_once('?') {
            None => say("t_ns=1&tick=0&y=0.0&u=0.0"),
            Some((_, query)) => {
                if let Some(body) = answer(query) {
                    say(&body);
                }
            }
        }
    }
}
