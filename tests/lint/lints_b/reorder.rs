//! The smallest order of members, against every order there is.

use landfall_layout::{Options, Source, layout};
use snapbox::str;

use crate::lints_b::{found, help, one, said, std140};
use crate::support::command::golden;

fn size(text: &str) -> u64 {
    let shader = layout(&Source::new("a.frag", text), &Options::default());
    shader.blocks[0].size.expect("a block has a size")
}

fn every_order(count: usize) -> Vec<Vec<usize>> {
    match count {
        0 => vec![Vec::new()],
        _ => every_order(count - 1)
            .into_iter()
            .flat_map(|order| {
                (0..count).map(move |at| {
                    let mut order = order.clone();
                    order.insert(at, count - 1);
                    order
                })
            })
            .collect(),
    }
}

#[test]
fn the_smallest_order_is_named_with_the_bytes_it_saves() {
    let members = "    float a;\n    vec3 b;\n    float c;\n    vec3 d;";
    let finding = one("reorder-saves", "a.frag", &std140(members));
    assert_eq!(said(&finding), "2:24 block `B` is 48 bytes: in another order its members take 32");
    let help = help(&finding);
    golden().eq(
        help,
        str![
            "declare the members in the order `b`, `a`, `d`, `c`: 32 bytes instead of 48, 16 saved"
        ],
    );
    golden().eq(
        finding.listing.as_deref().expect("it lists the new order"),
        str![[r#"
/*            align(16) size(32) */ layout(std140) uniform B {
/* offset( 0) align(16) size(12) */     vec3 b;
/* offset(12) align( 4) size( 4) */     float a;
/* offset(16) align(16) size(12) */     vec3 d;
/* offset(28) align( 4) size( 4) */     float c;
/*                               */ };
// 32 bytes: 32 used, 0 padding (0.0 %)
"#]],
    );
}

/// Members of every kind of size and alignment, drawn by a seeded generator.
#[test]
fn no_order_is_smaller_than_the_one_proposed() {
    let types = ["float", "vec2", "vec3", "vec4", "mat3", "float[3]", "double", "dvec3", "S"];
    let mut random = fastrand::Rng::with_seed(7);
    let (mut proposals, mut silent) = (0, 0);
    for _ in 0..150 {
        let count = random.usize(3..=6);
        let members: Vec<String> = (0..count)
            .map(|at| match types[random.usize(..types.len())].split_once('[') {
                Some((ty, dims)) => format!("{ty} m{at}[{dims};"),
                None => String::new(),
            })
            .collect();
        let members: Vec<String> = members
            .into_iter()
            .enumerate()
            .map(|(at, declared)| match declared.is_empty() {
                true => format!("{} m{at};", types[random.usize(..types.len())].replace("[3]", "")),
                false => declared,
            })
            .collect();
        let rules = ["std140", "std430"][random.usize(..2)];
        let text = |order: &[usize]| {
            let body: String = order.iter().map(|&at| members[at].as_str()).collect();
            format!(
                "#version 430\nstruct S {{ vec2 s; }};\nlayout({rules}) buffer B {{ {body} }};\n\
                 void main() {{}}\n"
            )
        };
        let written: Vec<usize> = (0..count).collect();
        let smallest = every_order(count).iter().map(|order| size(&text(order))).min();
        let smallest = smallest.expect("there is an order");
        let found = found("reorder-saves", "a.comp", &text(&written));
        let old = size(&text(&written));
        match found.iter().find(|finding| finding.about == "B") {
            Some(finding) => {
                proposals += 1;
                let wanted = format!("{smallest} bytes instead of {old}, {} saved", old - smallest);
                assert!(help(finding).contains(&wanted), "{}\n{finding:#?}", text(&written));
                // The order that is named is one with that size.
                let named: Vec<usize> = help(finding)
                    .split('`')
                    .filter_map(|word| word.strip_prefix('m')?.parse().ok())
                    .collect();
                assert_eq!(size(&text(&named)), smallest, "{named:?}\n{}", text(&written));
            }
            None => {
                silent += 1;
                assert_eq!(old, smallest, "{}", text(&written));
            }
        }
    }
    assert!(proposals > 20 && silent > 20, "{proposals} proposals, {silent} without");
}

#[test]
fn many_kinds_of_members_are_ordered_by_a_rule_of_thumb() {
    // 26 sizes of arrays, each followed by a scalar and a `vec3` that do not fit together.
    let members: String =
        (1..=26).map(|n| format!("float s{n}; vec3 v{n}; vec4 a{n}[{n}]; ")).collect();
    let text =
        format!("#version 430\nlayout(std140) uniform B {{ {members} }};\nvoid main() {{}}\n");
    let finding = one("reorder-saves", "a.frag", &text);
    // By hand: 26 pairs of `vec3` and `float` in 16 bytes each, and 16 * (1 + … + 26).
    let best = 26 * 16 + 16 * (26 * 27 / 2);
    let best = format!("{},{:03} bytes instead of", best / 1000, best % 1000);
    assert!(help(&finding).contains(&best), "{finding:?}");
}

#[test]
fn a_structure_says_what_the_block_around_it_saves() {
    let text = "#version 330 core
struct Light { float gain; vec3 color; float range; vec3 at; };
layout(std140) uniform B { Light lights[10]; };
void main() {}
";
    let finding = one("reorder-saves", "a.frag", text);
    assert_eq!(said(&finding), "2:8 `Light` is 48 bytes: in another order its members take 32");
    assert_eq!(finding.notes[0], "block `B` shrinks from 480 to 320");
    golden().eq(help(&finding), str!["declare the members in the order `color`, `gain`, `at`, `range`: 32 bytes instead of 48, 16 saved each"]);
}

/// A structure in two blocks: what is proposed for one of them is tried in both.
#[test]
fn an_order_that_makes_any_block_larger_is_not_proposed() {
    let types = ["float", "vec2", "vec3", "Inner", "Inner"];
    let mut random = fastrand::Rng::with_seed(3);
    let (mut proposals, mut withheld) = (0, 0);
    for _ in 0..200 {
        let members: Vec<String> = (0..random.usize(4..=6))
            .map(|at| format!("{} m{at};", types[random.usize(..types.len())]))
            .collect();
        let text = |order: &[usize], blocks: &str| {
            let body: String = order.iter().map(|&at| members[at].as_str()).collect();
            format!(
                "#version 430\nstruct Inner {{ float f; }};\nstruct S {{ {body} }};\n{blocks}\n\
                 void main() {{}}\n"
            )
        };
        let one_block = "layout(std140) uniform A { S a; };";
        let both = format!("{one_block}\nlayout(std430) buffer B {{ S b[4]; }};");
        let written: Vec<usize> = (0..members.len()).collect();
        let about_s = |text: &str| {
            let found = found("reorder-saves", "a.comp", text);
            found.into_iter().find(|finding| finding.about == "S")
        };
        let alone = about_s(&text(&written, one_block));
        let Some(finding) = about_s(&text(&written, &both)) else {
            withheld += usize::from(alone.is_some());
            continue;
        };
        proposals += 1;
        let named: Vec<usize> = help(&finding)
            .split('`')
            .filter_map(|word| word.strip_prefix('m')?.parse().ok())
            .collect();
        let sizes = |order: &[usize]| {
            let shader = layout(&Source::new("a.comp", text(order, &both)), &Options::default());
            shader.blocks.iter().map(|block| block.size).collect::<Vec<_>>()
        };
        let (old, new) = (sizes(&written), sizes(&named));
        assert!(new.iter().zip(&old).all(|(new, old)| new <= old), "{old:?} {new:?} {members:?}");
        assert_ne!(old, new);
    }
    assert!(proposals > 20 && withheld > 0, "{proposals} proposed, {withheld} withheld");
}

#[test]
fn an_explicit_offset_is_an_order_somebody_wants() {
    let bad = "#version 450\nlayout(std140) uniform B { float a; vec3 b; float c; vec3 d; };\nvoid main() {}\n";
    assert_eq!(found("reorder-saves", "a.frag", bad).len(), 1);
    let good = bad.replace("float a;", "layout(offset = 0) float a;");
    assert_eq!(found("reorder-saves", "a.frag", &good), []);
}

#[test]
fn a_runtime_sized_member_stays_last() {
    let text = "#version 430\nlayout(std430) buffer B { float a; vec3 b; float c; vec3 d; vec4 tail[]; };\nvoid main() {}\n";
    let finding = one("reorder-saves", "a.comp", text);
    golden().eq(
        help(&finding),
        str!["declare the members in the order `b`, `a`, `d`, `c`, `tail`: 48 bytes instead of 64, 16 saved"],
    );
}

#[test]
fn blocks_that_are_as_small_as_can_be_are_not_reported() {
    for members in
        ["vec3 a;\nfloat b;\nvec3 c;\nfloat d;", "float a;\nvec4 b;", "vec3 a; vec3 b; vec3 c;"]
    {
        assert_eq!(found("reorder-saves", "a.frag", &std140(members)), [], "{members}");
    }
}

#[test]
fn two_members_are_enough_to_save() {
    let finding = one("reorder-saves", "a.frag", &std140("    float a;\n    vec3 b;"));
    assert_eq!(said(&finding), "2:24 block `B` is 32 bytes: in another order its members take 16");
    assert_eq!(found("reorder-saves", "a.frag", &std140("    vec3 b;\n    float a;")), []);
}
