//! Disturbs packets by the kernel's own means, in the namespaces of the ends: leads them around the
//! link, drops them, or sends them through a rate.

use std::fs;

use link::Way;

use crate::target::{Target, inside, tool};

/// Where the plant listens: packets to this port go up, packets from it go down.
pub(crate) const PLANT_PORT: u16 = 8080;

/// The iptables match for the TCP packets of a way.
pub(crate) fn tcp(way: Way) -> String {
    match way {
        Way::Up => format!("-p tcp --dport {PLANT_PORT}"),
        Way::Down => format!("-p tcp --sport {PLANT_PORT}"),
    }
}

/// Leads the TCP packets of `ways`, and no others, over a cable of their own from end to end.
pub(crate) fn lead_around(target: &Target, ways: &[Way]) -> Result<String, String> {
    if target.player.is_none() {
        return Err("over loopback there is no link to be led around".to_owned());
    }
    let (controller, plant) = (shaper::CONTROLLER_ADDRESS, shaper::PLANT_ADDRESS);
    let (at_controller, at_plant) = ("02:77:00:00:02:01", "02:77:00:00:02:02");
    inside(target.controller, || {
        tool(&format!(
            "ip link add around0 address {at_controller} type veth \
             peer name around0 address {at_plant} netns {}",
            target.plant
        ))
    })?;
    for (end, peer, mac) in [
        (target.controller, plant, at_plant),
        (target.plant, controller, at_controller),
    ] {
        inside(end, || {
            tool("ip link set around0 up")?;
            tool(&format!(
                "ip neigh add {peer} lladdr {mac} dev around0 nud permanent"
            ))?;
            tool(&format!("ip route add {peer} dev around0 table 77"))
        })?;
    }
    let rule = |verb: &str| {
        ways.iter().try_for_each(|way| {
            let line = format!("ip rule {verb} pref 10 ipproto tcp lookup 77");
            inside(target.source(*way), || tool(&line)).map(drop)
        })
    };
    target.await_beginning()?;
    rule("add")?;
    let from = target.now();
    target.await_end()?;
    rule("del")?;
    // In /sys and /proc, only this file shows the namespace of its reader.
    let read =
        || fs::read_to_string("/proc/thread-self/net/dev").map_err(|problem| problem.to_string());
    let sent = ways.iter().map(|way| {
        let table = inside(target.source(*way), read)?;
        let line = table.lines().find(|line| line.contains("around0"));
        // After the name come eight columns of what was received, then bytes and packets that were
        // sent.
        let count = line.and_then(|line| line.split_whitespace().nth(10));
        Ok(format!("{} packets {way}", count.unwrap_or("?")))
    });
    let sent: Vec<_> = sent.collect::<Result<_, String>>()?;
    Ok(format!("led around {from}: {}", sent.join(", ")))
}

/// Drops this percentage of the TCP packets of each way, where they come out of the link.
pub(crate) fn drop_tcp(target: &Target, percent: u32) -> Result<String, String> {
    let ways = [Way::Up, Way::Down];
    let rule = |verb: &str, way: Way| {
        let line = format!(
            "iptables -{verb} INPUT {} -m statistic --mode random --probability {} -j DROP",
            tcp(way),
            f64::from(percent) / 100.0
        );
        inside(target.sink(way), || tool(&line))
    };
    target.await_beginning()?;
    for way in ways {
        rule("A", way)?;
    }
    let from = target.now();
    target.await_end()?;
    let mut dropped = Vec::new();
    for way in ways {
        // The first columns of each rule are packets and bytes.
        let list = inside(target.sink(way), || tool("iptables -L INPUT -n -v -x"))?;
        let port = if way == Way::Up { "dpt" } else { "spt" };
        let count = list
            .lines()
            .find(|line| line.contains(port))
            .and_then(|line| line.split_whitespace().next())
            .unwrap_or("?");
        dropped.push(format!("{count} packets {way}"));
        rule("D", way)?;
    }
    Ok(format!("dropped {from}: {}", dropped.join(", ")))
}

/// Sends what leaves each end through a rate limit: everything, or everything except echoes.
pub(crate) fn limit_rate(
    target: &Target,
    rate: &str,
    spares_echoes: bool,
) -> Result<String, String> {
    let device = target.device();
    let on = if spares_echoes {
        vec![
            format!("tc qdisc add dev {device} root handle 1: htb default 20"),
            format!("tc class add dev {device} parent 1: classid 1:10 htb rate 10gbit"),
            format!(
                "tc class add dev {device} parent 1: classid 1:20 htb rate {rate} \
                 burst 1600 cburst 1600"
            ),
            format!(
                "tc filter add dev {device} parent 1: protocol ip u32 \
                 match ip protocol 1 0xff flowid 1:10"
            ),
        ]
    } else {
        vec![format!(
            "tc qdisc add dev {device} root tbf rate {rate} burst 1600 limit 200000"
        )]
    };
    let all = |lines: &[String]| {
        target.ends().into_iter().try_for_each(|end| {
            inside(end, || {
                lines.iter().try_for_each(|line| tool(line).map(drop))
            })
        })
    };
    target.await_beginning()?;
    all(&on)?;
    let from = target.now();
    target.await_end()?;
    let said = target
        .ends()
        .into_iter()
        .map(|end| inside(end, || tool(&format!("tc -s qdisc show dev {device}"))))
        .collect::<Result<Vec<_>, _>>()?;
    all(&[format!("tc qdisc del dev {device} root")])?;
    let counts: Vec<_> = said
        .iter()
        .filter_map(|said| said.lines().find(|line| line.contains("overlimits")))
        .map(str::trim)
        .collect();
    Ok(format!(
        "through a bucket of {rate} {from}: {}",
        counts.join("; ")
    ))
}
