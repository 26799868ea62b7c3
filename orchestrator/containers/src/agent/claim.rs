//! Which orchestrator an agent belongs to, and how long the agent waits without hearing from it.
//!
//! While a request is being answered, the orchestrator counts as heard. Time is an argument.

use std::time::Duration;

use tokio::time::Instant;

use crate::agent::config::{Config, Ended};
use crate::agent::refusal::Refusal;
use crate::token::Token;

/// The claim on an agent.
#[derive(Debug)]
pub(crate) struct Claim {
    token: Option<Token>,
    claimed: bool,
    /// When the agent started; later, when the orchestrator's last request began or ended.
    heard: Instant,
    /// Number of the orchestrator's requests that are being answered.
    under_way: u32,
    unclaimed: Duration,
    silence: Duration,
}

impl Claim {
    pub(crate) fn new(config: &Config, now: Instant) -> Claim {
        Claim {
            token: config.token.clone(),
            claimed: false,
            heard: now,
            under_way: 0,
            unclaimed: config.unclaimed,
            silence: config.silence,
        }
    }

    pub(crate) fn claimed(&self) -> bool {
        self.claimed
    }

    /// Claims the agent with the token that was presented.
    pub(crate) fn claim(&mut self, presented: Option<Token>, now: Instant) -> Result<(), Refusal> {
        let presented = presented.ok_or(Refusal::Token)?;
        match &self.token {
            Some(token) if token.is(&presented) => {}
            Some(_) if self.claimed => return Err(Refusal::Claimed),
            Some(_) => return Err(Refusal::Token),
            None => self.token = Some(presented),
        }
        self.claimed = true;
        self.heard = now;
        Ok(())
    }

    /// Admits a request of the orchestrator; [`Claim::answered`] has to follow.
    pub(crate) fn enter(&mut self, presented: Option<&Token>, now: Instant) -> Result<(), Refusal> {
        match (&self.token, presented) {
            (_, None) => Err(Refusal::Token),
            (None, Some(_)) => Err(Refusal::Unclaimed),
            (Some(token), Some(presented)) if token.is(presented) => {
                // An orchestrator that was given the token beforehand need not claim.
                self.claimed = true;
                self.heard = now;
                self.under_way += 1;
                Ok(())
            }
            _ => Err(Refusal::Token),
        }
    }

    pub(crate) fn answered(&mut self, now: Instant) {
        self.under_way -= 1;
        self.heard = now;
    }

    /// When the agent will end if it hears nothing until then.
    pub(crate) fn ends(&self, now: Instant) -> Instant {
        match (self.claimed, self.under_way) {
            (false, _) => self.heard + self.unclaimed,
            (true, 0) => self.heard + self.silence,
            (true, _) => now + self.silence,
        }
    }

    /// Why it will end then.
    pub(crate) fn ended(&self) -> Ended {
        if self.claimed {
            Ended::Silent(self.silence)
        } else {
            Ended::Unclaimed(self.unclaimed)
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    const S: Duration = Duration::from_secs(1);

    fn claim(token: Option<&Token>, now: Instant) -> Claim {
        let config = Config {
            listen: "127.0.0.1:0".parse().unwrap(),
            hosts: Vec::new(),
            name: crate::AgentName::Plant,
            scratch: "/nowhere".into(),
            token: token.cloned(),
            unclaimed: 60 * S,
            silence: 30 * S,
            program: "/nowhere".into(),
        };
        Claim::new(&config, now)
    }

    #[test]
    fn the_first_token_is_the_agents_and_no_other() {
        let (mine, other) = (Token::random().unwrap(), Token::random().unwrap());
        let now = Instant::now();
        let mut claim = claim(None, now);
        assert!(matches!(
            claim.enter(Some(&mine), now),
            Err(Refusal::Unclaimed)
        ));
        assert!(matches!(claim.claim(None, now), Err(Refusal::Token)));
        claim.claim(Some(mine.clone()), now).unwrap();
        claim.claim(Some(mine.clone()), now).unwrap();
        assert!(matches!(
            claim.claim(Some(other.clone()), now),
            Err(Refusal::Claimed)
        ));
        assert!(matches!(
            claim.enter(Some(&other), now),
            Err(Refusal::Token)
        ));
        assert!(matches!(claim.enter(None, now), Err(Refusal::Token)));
        claim.enter(Some(&mine), now).unwrap();
    }

    #[test]
    fn a_token_given_beforehand_cannot_be_taken_by_who_comes_first() {
        let (mine, other) = (Token::random().unwrap(), Token::random().unwrap());
        let now = Instant::now();
        let mut claim = claim(Some(&mine), now);
        assert!(matches!(claim.claim(Some(other), now), Err(Refusal::Token)));
        assert!(!claim.claimed());
        claim.enter(Some(&mine), now).unwrap();
        assert!(claim.claimed());
    }

    #[test]
    fn it_waits_longer_to_be_claimed_than_to_hear_again_and_never_during_a_request() {
        let token = Token::random().unwrap();
        let start = Instant::now();
        let mut claim = claim(None, start);
        assert_eq!(claim.ends(start + 5 * S), start + 60 * S);
        assert_eq!(claim.ended(), Ended::Unclaimed(60 * S));
        claim.claim(Some(token.clone()), start + 10 * S).unwrap();
        assert_eq!(claim.ends(start + 11 * S), start + 40 * S);
        assert_eq!(claim.ended(), Ended::Silent(30 * S));
        claim.enter(Some(&token), start + 20 * S).unwrap();
        assert_eq!(claim.ends(start + 100 * S), start + 130 * S);
        claim.answered(start + 100 * S);
        assert_eq!(claim.ends(start + 101 * S), start + 130 * S);
    }
}
