//! A checksum at the end of a message, `&crc=` and eight hex digits: CRC-32C of the text before it.
//!
//! TCP's own checksum has 16 bits and is made anew by every box on the way, so a message that a broken one has
//! changed can still look valid: `u=0.5` becomes `u=0.7`. Both ends leave this out unless they are told.

use crate::query::{InvalidMessage, excerpt};

/// How the field begins, which is the last of a message.
const FIELD: &str = "&crc=";

/// Castagnoli's polynomial, with the lowest bit first.
const POLYNOMIAL: u32 = 0x82f6_3b78;

/// What each byte adds.
const TABLE: [u32; 256] = {
    let mut table = [0; 256];
    let mut byte = 0;
    while byte < 256 {
        let (mut crc, mut bit) = (byte as u32, 0);
        while bit < 8 {
            crc = if crc & 1 == 1 {
                crc >> 1 ^ POLYNOMIAL
            } else {
                crc >> 1
            };
            bit += 1;
        }
        table[byte] = crc;
        byte += 1;
    }
    table
};

/// CRC-32C of a text.
fn crc(text: &str) -> u32 {
    !text.bytes().fold(!0, |crc, byte| {
        crc >> 8 ^ TABLE[usize::from(byte ^ crc.to_le_bytes()[0])]
    })
}

/// The message with its checksum.
#[must_use]
pub fn signed(message: &str) -> String {
    format!("{message}{FIELD}{:08x}", crc(message))
}

/// The message without its checksum, and whether it had one.
///
/// # Errors
/// [`InvalidMessage::Checksum`] if that is not its own, [`InvalidMessage::NoChecksum`] if it has none and
/// `is_needed`.
pub fn checked(text: &str, is_needed: bool) -> Result<(&str, bool), InvalidMessage> {
    // Faster than to look for the whole field, which hardly any message has.
    let mut places = text
        .rmatch_indices('&')
        .map(|(place, _)| text.split_at(place));
    let field = places.find_map(|(message, field)| Some((message, field.strip_prefix(FIELD)?)));
    let Some((message, told)) = field else {
        return if is_needed {
            Err(InvalidMessage::NoChecksum)
        } else {
            Ok((text, false))
        };
    };
    let own = format!("{:08x}", crc(message));
    if told == own {
        return Ok((message, true));
    }
    Err(InvalidMessage::Checksum {
        told: excerpt(told),
        own,
    })
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn it_is_that_of_rfc_3720() {
        assert_eq!(crc("123456789"), 0xe306_9283);
        assert_eq!(crc(&"\0".repeat(32)), 0x8a91_36aa);
        assert_eq!(signed("u=1"), format!("u=1&crc={:08x}", crc("u=1")));
    }

    #[test]
    fn a_message_without_is_taken_only_where_none_is_needed() {
        assert_eq!(checked("u=1", false), Ok(("u=1", false)));
        assert_eq!(checked("u=1", true), Err(InvalidMessage::NoChecksum));
        let error = checked("u=1&crc=12345678", false).expect_err("another's");
        assert!(error.to_string().contains("`crc` 12345678"), "{error}");
    }

    proptest! {
        /// Whatever bytes of a message are changed, it is never read as another.
        #[test]
        fn a_changed_message_is_not_taken(
            seq in any::<u64>(), u in -1e6..1e6_f64,
            flips in prop::collection::vec((any::<prop::sample::Index>(), 0..7_u8), 1..5),
        ) {
            let message = format!("seq={seq}&t_send_ns=5&u={u}");
            let sent = signed(&message);
            prop_assert_eq!(checked(&sent, true), Ok((message.as_str(), true)));
            let mut bytes = sent.clone().into_bytes();
            for (place, bit) in flips {
                let place = place.index(bytes.len());
                bytes[place] ^= 1 << bit;
            }
            // Bits 0 to 6 of ASCII stay ASCII.
            let came = String::from_utf8(bytes).expect("ASCII");
            prop_assume!(came != sent);
            prop_assert!(checked(&came, true).is_err(), "{came}");
        }
    }
}
