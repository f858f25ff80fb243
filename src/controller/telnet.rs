//! Telnet's own words in a stream of bytes, taken out.
//!
//! A telnet program may open with offers (RFC 854, RFC 855): the byte 255 (IAC), a verb, the number of an option. Those numbers are not
//! for a controller: option 24, the terminal's type, is its soft reset, and option 33, flow control, its feed hold. So they are taken
//! out, and each offer is declined as RFC 854 asks. A program that speaks no telnet never sends 255, which means nothing to GRBL either.
//!
//! A value without I/O: bytes in, bytes for the controller and bytes for the host out.

const IAC: u8 = 255;
const DONT: u8 = 254;
const DO: u8 = 253;
const WONT: u8 = 252;
const WILL: u8 = 251;
/// Begins the talk about an option ...
const SB: u8 = 250;
/// ... and ends it.
const SE: u8 = 240;
/// The longest talk about an option; what is longer is none.
const LONGEST: usize = 256;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Place {
    #[default]
    Data,
    Command,
    /// Behind a verb: the option comes next.
    Option(u8),
    /// So many bytes into the talk about an option; the last one was IAC or not.
    Talk(usize, bool),
}

/// Where in the stream we are.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Telnet {
    place: Place,
}

impl Telnet {
    /// Takes telnet's words out of `bytes`, which keep their order and shrink to the length returned; `answer` gets what is to be said
    /// to them.
    pub fn strip(&mut self, bytes: &mut [u8], answer: &mut Vec<u8>) -> usize {
        let mut kept = 0;
        for i in 0..bytes.len() {
            let Some(&byte) = bytes.get(i) else { break };
            if let Some(data) = self.step(byte, answer)
                && let Some(slot) = bytes.get_mut(kept)
            {
                *slot = data;
                kept += 1;
            }
        }
        kept
    }

    /// One byte; what of it is for the controller.
    fn step(&mut self, byte: u8, answer: &mut Vec<u8>) -> Option<u8> {
        let (next, data) = match (self.place, byte) {
            (Place::Data, IAC) => (Place::Command, None),
            (Place::Data, _) => (Place::Data, Some(byte)),
            // Twice is the byte itself.
            (Place::Command, IAC) => (Place::Data, Some(IAC)),
            (Place::Command, WILL | WONT | DO | DONT) => (Place::Option(byte), None),
            (Place::Command, SB) => (Place::Talk(0, false), None),
            (Place::Command, _) => (Place::Data, None),
            (Place::Option(verb), _) => {
                match verb {
                    WILL => answer.extend([IAC, DONT, byte]),
                    DO => answer.extend([IAC, WONT, byte]),
                    // Agreed.
                    _ => {}
                }
                (Place::Data, None)
            }
            (Place::Talk(_, true), SE) => (Place::Data, None),
            (Place::Talk(n, _), _) if n >= LONGEST => (Place::Data, None),
            (Place::Talk(n, was), _) => (Place::Talk(n + 1, byte == IAC && !was), None),
        };
        self.place = next;
        data
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Fed in these pieces: what is left, and what was answered.
    fn strip(pieces: &[&[u8]]) -> (Vec<u8>, Vec<u8>) {
        let (mut telnet, mut kept, mut answer) = (Telnet::default(), Vec::new(), Vec::new());
        for piece in pieces {
            let mut bytes = piece.to_vec();
            let n = telnet.strip(&mut bytes, &mut answer);
            kept.extend_from_slice(&bytes[..n]);
        }
        (kept, answer)
    }

    #[test]
    fn offers_are_declined_and_never_heard_as_a_reset_or_a_hold() {
        // What a telnet program says first: terminal type (24 is 0x18), flow control (33 is '!'), and it does ECHO (1).
        let offers = [255, 251, 24, 255, 253, 33, 255, 252, 1, b'?'];
        assert_eq!(
            strip(&[&offers]),
            (vec![b'?'], vec![255, 254, 24, 255, 252, 33])
        );
        // In the middle of a line, and torn apart.
        assert_eq!(
            strip(&[b"G1\xff", b"\xfb", b"\x18X1\n"]).0,
            b"G1X1\n".to_vec()
        );
    }

    #[test]
    fn talk_about_options_is_skipped_but_not_for_ever() {
        let talk = b"A\xff\xfa\x18\x00xterm!\xff\xff\x18\xff\xf0B";
        assert_eq!(strip(&[talk]), (b"AB".to_vec(), vec![]));
        let mut endless = b"\xff\xfa".to_vec();
        endless.extend([b'x'; LONGEST + 1]);
        endless.extend(b"?$X\n");
        assert_eq!(strip(&[&endless]).0, b"?$X\n".to_vec());
        assert_eq!(strip(&[b"a\xff\xffb\xff\xf1c"]).0, b"a\xffbc".to_vec());
    }

    proptest! {
        /// Without a 255 nothing is changed; with any bytes, torn anywhere, the same is left.
        #[test]
        fn others_are_left_alone(bytes in proptest::collection::vec(any::<u8>(), 0..300), cut: prop::sample::Index) {
            let plain: Vec<u8> = bytes.iter().map(|b| b & 0x7f).collect();
            prop_assert_eq!(strip(&[&plain]), (plain.clone(), Vec::new()));
            let at = cut.index(bytes.len() + 1);
            prop_assert_eq!(strip(&[&bytes]), strip(&[&bytes[..at], &bytes[at..]]));
        }
    }
}
