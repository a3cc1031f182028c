//! The messages between rig and guard: one datagram each, of a fixed form, so that neither side allocates for them.

use rustix::io::{self, Errno};
use rustix::net::{
    RecvAncillaryBuffer, RecvAncillaryMessage, RecvFlags, SendAncillaryBuffer, SendAncillaryMessage,
    SendFlags, recvmsg, sendmsg,
};
use std::io::{IoSlice, IoSliceMut};
use std::mem::MaybeUninit;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};

/// Most bytes of text in a message.
pub(crate) const MOST_TEXT: usize = 200;
/// Most descriptors in a message.
const MOST_DESCRIPTORS: usize = 2;
/// What stands in place of the number of lines for an output of a PWM chip.
pub(crate) const PWM: i64 = -1;
/// Numbers in a message.
const NUMBERS: usize = 4;
/// Bytes before the text: the tag and the numbers.
const HEAD: usize = 1 + NUMBERS * 8;
/// Room for the descriptors.
const CONTROL: usize = rustix::cmsg_space!(ScmRights(MOST_DESCRIPTORS));

/// What a message is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Tag {
    /// Settings, the shared page and the rig's own process.
    Hello,
    /// Lets go of the lines held so far.
    Forget,
    /// Lets go of the lines of one device, which is gone.
    Release,
    /// Lines to hold.
    Hold,
    /// The rig drives from now on.
    Arm,
    /// The rig does not drive any more.
    Disarm,
    /// The rig cannot make its outputs safe.
    Trip,
    /// The end.
    Close,
    /// Another rig needs the lines.
    TakeOver,
    /// The answer: done.
    Done,
    /// The answer: not done.
    Refused,
}

const TAGS: [Tag; 11] = [
    Tag::Hello,
    Tag::Forget,
    Tag::Release,
    Tag::Hold,
    Tag::Arm,
    Tag::Disarm,
    Tag::Trip,
    Tag::Close,
    Tag::TakeOver,
    Tag::Done,
    Tag::Refused,
];

/// A message.
#[derive(Clone, Copy, Debug)]
pub(crate) struct GuardMessage {
    pub tag: Tag,
    pub numbers: [i64; NUMBERS],
    text: [u8; MOST_TEXT],
    length: usize,
}

impl GuardMessage {
    /// A message without text.
    pub fn new(tag: Tag, numbers: [i64; NUMBERS]) -> GuardMessage {
        GuardMessage { tag, numbers, text: [0; MOST_TEXT], length: 0 }
    }

    /// The same with a text; what is too long is cut off.
    #[must_use]
    pub fn with(mut self, text: &str) -> GuardMessage {
        let mut length = text.len().min(MOST_TEXT);
        while !text.is_char_boundary(length) {
            length -= 1;
        }
        self.text[..length].copy_from_slice(&text.as_bytes()[..length]);
        self.length = length;
        self
    }

    /// Its text.
    pub fn text(&self) -> &str {
        std::str::from_utf8(&self.text[..self.length]).unwrap_or_default()
    }

    /// Sends it, without waiting for room.
    ///
    /// # Errors
    /// EPIPE or ECONNRESET where the other side is gone.
    pub fn send(&self, to: impl AsFd, descriptors: &[BorrowedFd]) -> io::Result<()> {
        let mut bytes = [0; HEAD + MOST_TEXT];
        bytes[0] = self.tag as u8;
        for (place, number) in bytes[1..HEAD].chunks_exact_mut(8).zip(self.numbers) {
            place.copy_from_slice(&number.to_le_bytes());
        }
        bytes[HEAD..].copy_from_slice(&self.text);
        let whole = [IoSlice::new(&bytes[..HEAD + self.length])];
        let mut room = [MaybeUninit::uninit(); CONTROL];
        let mut control = SendAncillaryBuffer::new(&mut room);
        if !descriptors.is_empty() && !control.push(SendAncillaryMessage::ScmRights(descriptors)) {
            return Err(Errno::TOOBIG);
        }
        sendmsg(to, &whole, &mut control, SendFlags::NOSIGNAL | SendFlags::DONTWAIT)?;
        Ok(())
    }

    /// Takes one, without waiting for it. `None`: the other side is gone.
    ///
    /// # Errors
    /// EAGAIN where there is none; EBADMSG for what is no message.
    pub fn receive(from: impl AsFd) -> io::Result<Option<(GuardMessage, Descriptors)>> {
        let mut bytes = [0; HEAD + MOST_TEXT];
        let mut room = [MaybeUninit::uninit(); CONTROL];
        let mut control = RecvAncillaryBuffer::new(&mut room);
        let flags = RecvFlags::DONTWAIT | RecvFlags::CMSG_CLOEXEC;
        let got = recvmsg(from, &mut [IoSliceMut::new(&mut bytes)], &mut control, flags)?;
        let mut descriptors = Descriptors::default();
        for message in control.drain() {
            if let RecvAncillaryMessage::ScmRights(rights) = message {
                for (place, descriptor) in descriptors.0.iter_mut().zip(rights) {
                    *place = Some(descriptor);
                }
            }
        }
        if got.bytes == 0 {
            return Ok(None);
        }
        let tag = TAGS.get(usize::from(bytes[0]));
        let (Some(tag), true) = (tag, got.bytes >= HEAD) else { return Err(Errno::BADMSG) };
        let mut message = GuardMessage::new(*tag, [0; NUMBERS]);
        for (number, place) in message.numbers.iter_mut().zip(bytes[1..HEAD].chunks_exact(8)) {
            *number = i64::from_le_bytes(place.try_into().unwrap_or_default());
        }
        message.length = got.bytes - HEAD;
        message.text.copy_from_slice(&bytes[HEAD..]);
        Ok(Some((message, descriptors)))
    }
}

/// The descriptors that came with a message, in order.
#[derive(Debug, Default)]
pub(crate) struct Descriptors([Option<OwnedFd>; MOST_DESCRIPTORS]);

impl Descriptors {
    /// The next one.
    pub fn next(&mut self) -> Option<OwnedFd> {
        self.0.iter_mut().find_map(Option::take)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rustix::net::{AddressFamily, SocketFlags, SocketType, send, socketpair};
    use std::io::{Read, Write};

    fn pair() -> (OwnedFd, OwnedFd) {
        socketpair(AddressFamily::UNIX, SocketType::SEQPACKET, SocketFlags::CLOEXEC, None).unwrap()
    }

    #[test]
    fn a_message_arrives_whole_with_its_descriptors() {
        let (rig, guard) = pair();
        let (mut reader, mut writer) = std::io::pipe().unwrap();
        let sent = GuardMessage::new(Tag::Hold, [1, -2, i64::MAX, i64::MIN]).with("rig-gpio");
        sent.send(&rig, &[writer.as_fd()]).unwrap();
        writer.write_all(b"a").unwrap();
        drop(writer);
        let (got, mut descriptors) = GuardMessage::receive(&guard).unwrap().unwrap();
        assert_eq!((got.tag, got.numbers, got.text()), (Tag::Hold, sent.numbers, "rig-gpio"));
        let mut other = std::fs::File::from(descriptors.next().unwrap());
        other.write_all(b"b").unwrap();
        drop(other);
        assert!(descriptors.next().is_none());
        let mut all = String::new();
        reader.read_to_string(&mut all).unwrap();
        assert_eq!(all, "ab");
    }

    #[test]
    fn none_yet_gone_and_nonsense_are_told_apart() {
        let (rig, guard) = pair();
        assert_eq!(GuardMessage::receive(&guard).unwrap_err(), Errno::AGAIN);
        for nonsense in [&[0][..], &[200; HEAD][..], &[0; HEAD - 1][..]] {
            send(&rig, nonsense, SendFlags::empty()).unwrap();
            assert_eq!(GuardMessage::receive(&guard).unwrap_err(), Errno::BADMSG);
        }
        drop(rig);
        assert!(GuardMessage::receive(&guard).unwrap().is_none());
    }

    #[test]
    fn a_long_text_is_cut_at_a_letter() {
        let text = "ä".repeat(MOST_TEXT);
        let message = GuardMessage::new(Tag::Done, [0; NUMBERS]).with(&text);
        assert_eq!(message.text(), &text[..MOST_TEXT / 2 * 2]);
        assert_eq!(
            GuardMessage::new(Tag::Done, [0; NUMBERS]).with("x").with(&format!("x{text}")).text().len(),
            MOST_TEXT - 1
        );
    }
}
