//! The places of the images that sources name.

use crate::{Options, compile};
use document::SourceFile;

#[test]
fn places_of_the_images_are_listed_by_their_addresses_with_where_they_are_named_first() {
    let text = "VAR_GLOBAL all AT %IB2 : ARRAY [0..9] OF BYTE; END_VAR
PROGRAM MAIN VAR lamp AT %QX0.4 : BOOL; m AT %MW3 : INT; END_VAR
lamp := %IX0.1 OR %IX0.1; %QW3 := 5; m := %MW7;
END_PROGRAM";
    let program = compile(&[SourceFile::new("a.st", text)], &Options::default()).unwrap();
    let found: Vec<(String, u32, usize)> =
        program.images().iter().map(|one| (one.address.to_string(), one.bits, one.span.start)).collect();
    let at = |place: &str, bits| (place.to_owned(), bits, text.find(place).unwrap());
    assert_eq!(found, [at("%IX0.1", 1), at("%IB2", 80), at("%QX0.4", 1), at("%QW3", 16)]);
}
