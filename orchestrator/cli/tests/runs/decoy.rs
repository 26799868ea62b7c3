//! Things that look like a run's own and are not: whoever cleans up by name or by kind would take them along.

use std::fs;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

/// Of each decoy its name, and the commands that make it, list it and remove it. A machine may refuse some.
const MADE: [(&str, &str, &str, &str); 5] = [
    (
        "a named namespace",
        "ip netns add webloop-decoy",
        "ip netns list",
        "ip netns del webloop-decoy",
    ),
    (
        "a veth",
        "ip link add x-eth0 type veth peer name x-eth1",
        "ip -o link show x-eth0",
        "ip link del x-eth0",
    ),
    (
        "a qdisc",
        "tc qdisc add dev x-eth1 root tbf rate 1mbit burst 10k latency 1s",
        "tc qdisc show dev x-eth1",
        "true",
    ),
    (
        "a bridge",
        "ip link add webloop-br type bridge",
        "ip -o link show webloop-br",
        "ip link del webloop-br",
    ),
    (
        "a TUN",
        "ip tuntap add webloop-tun mode tun",
        "ip -o link show webloop-tun",
        "ip tuntap del webloop-tun mode tun",
    ),
];

/// The decoys, until they are dropped.
pub(crate) struct Decoys {
    made: Vec<(usize, String)>,
    process: Child,
    file: PathBuf,
}

impl Decoys {
    pub(crate) fn make() -> Decoys {
        let made = MADE
            .iter()
            .enumerate()
            .filter_map(|(n, (_, make, show, _))| {
                shell(make)?;
                Some((n, shell(show)?))
            });
        let made = made.collect();
        let process = Command::new("sleep")
            .arg0("webloop serve link")
            .arg("3600")
            .stdin(Stdio::null())
            .spawn()
            .unwrap();
        let file = std::env::temp_dir().join("webloop-decoy");
        fs::write(&file, "foreign").unwrap();
        Decoys {
            made,
            process,
            file,
        }
    }

    /// Checks that each is as it was made. Returns how many there are, in words.
    pub(crate) fn check(&mut self) -> String {
        for (n, was) in &self.made {
            let (name, _, show, _) = MADE[*n];
            assert_eq!(shell(show).as_ref(), Some(was), "{name}");
        }
        assert!(self.process.try_wait().unwrap().is_none(), "the process");
        assert_eq!(fs::read_to_string(&self.file).unwrap(), "foreign");
        let names = self.made.iter().map(|(n, _)| MADE[*n].0);
        let names: Vec<_> = names.chain(["a process", "a file"]).collect();
        format!("{} decoys ({})", names.len(), names.join(", "))
    }
}

impl Drop for Decoys {
    fn drop(&mut self) {
        for (n, _) in &self.made {
            shell(MADE[*n].3);
        }
        let _ = self.process.kill();
        let _ = self.process.wait();
        let _ = fs::remove_file(&self.file);
    }
}

/// What a command printed; `None` if it failed.
fn shell(line: &str) -> Option<String> {
    let output = Command::new("sh").args(["-c", line]).output().ok()?;
    let said = String::from_utf8_lossy(&output.stdout).into_owned();
    output.status.success().then_some(said)
}
