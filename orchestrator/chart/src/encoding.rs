//! Which font a character is in, and by which code: what PDF's own fonts can write.
//!
//! Helvetica has what Windows' code page 1252 has, Symbol the signs and the Greek that formulas
//! need. What neither has is written as `?`.

/// The font and the code in it of a character: `S`, which is Symbol, in its own encoding, or
/// `plain` in `WinAnsiEncoding`.
pub(crate) fn code(c: char, plain: &str) -> (&str, u8) {
    let symbol = match c {
        '−' => 0x2d,
        '≤' => 0xa3,
        '≥' => 0xb3,
        '≈' => 0xbb,
        '≠' => 0xb9,
        '→' => 0xae,
        '∞' => 0xa5,
        '√' => 0xd6,
        'Δ' => b'D',
        'Σ' => b'S',
        'α' => b'a',
        'β' => b'b',
        'γ' => b'g',
        'δ' => b'd',
        'ε' => b'e',
        'ζ' => b'z',
        'λ' => b'l',
        'π' => b'p',
        'σ' => b's',
        'τ' => b't',
        'φ' => b'f',
        'ω' => b'w',
        _ => 0,
    };
    if symbol != 0 {
        return ("S", symbol);
    }
    let latin = match c {
        '€' => 0x80,
        '…' => 0x85,
        '‘' => 0x91,
        '’' => 0x92,
        '“' => 0x93,
        '”' => 0x94,
        '•' => 0x95,
        '–' | '‑' => 0x96,
        '—' => 0x97,
        'μ' => 0xb5,
        ' '..='~' | '\u{a0}'..='\u{ff}' => u8::try_from(c).unwrap_or(b'?'),
        _ => b'?',
    };
    (plain, latin)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn characters_are_where_the_encodings_have_them() {
        assert_eq!(code('A', "F"), ("F", 0x41));
        assert_eq!(code('±', "F"), ("F", 0xb1));
        assert_eq!(code('–', "B"), ("B", 0x96));
        assert_eq!(code('−', "B"), ("S", 0x2d));
        assert_eq!(code('≤', "F"), ("S", 0xa3));
        assert_eq!(code('語', "F"), ("F", b'?'));
    }
}
