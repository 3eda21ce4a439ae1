//! Names as words.

use landfall_ir::analysis::identifier::identifier_words;

#[test]
fn names_in_every_fashion_come_apart() {
    assert_eq!(identifier_words("outerCutOff"), ["outer", "cutoff"]);
    assert_eq!(identifier_words("u_point_light_array"), ["point", "light", "array"]);
    assert_eq!(identifier_words("NR_POINT_LIGHTS"), ["nr", "point", "lights"]);
    assert_eq!(identifier_words("conedir"), ["cone", "dir"]);
    assert_eq!(identifier_words("lightPositions2"), ["light", "positions"]);
    assert_eq!(identifier_words("PBRLight"), ["pbr", "light"]);
    assert_eq!(identifier_words("cutoff"), ["cutoff"]);
    assert_eq!(identifier_words("direction"), ["direction"]);
    assert_eq!(identifier_words("x"), ["x"]);
}
