//! Locks of shaders with variants: 300 random shaders with nested conditions and sets of macros.
//!
//! What each set gives is computed here, from the tree of conditions that a text is printed from, and
//! the offsets by the std140 rules of the few types in it (OpenGL 4.6 §7.6.2.2, rules 1 to 5).

use std::collections::BTreeMap;
use std::fmt::Write as _;

use fastrand::Rng;
use landfall_layout::finding::Finding;
use landfall_layout::{Options, ShaderLayout, Source, layout, lock, variant_name};
use landfall_lint::drift::drift;
use serde_json::Value;

use crate::support::sample::{everything, sample};

const SHADERS: u64 = 300;

const MACROS: [&str; 4] = ["SHADOWS", "FOG", "SKIN", "LIGHTS"];

/// Type, alignment and size in std140.
const TYPES: [(&str, u64, u64); 6] = [
    ("float", 4, 4),
    ("int", 4, 4),
    ("vec2", 8, 8),
    ("vec3", 16, 12),
    ("vec4", 16, 16),
    ("mat4", 16, 64),
];

type Set = Vec<(String, String)>;

#[derive(Clone)]
enum Condition {
    Defined(&'static str),
    Undefined(&'static str),
    Both(&'static str, &'static str),
    MoreLights(u64),
}

impl Condition {
    fn random(random: &mut Rng) -> Condition {
        let name = MACROS[random.usize(..3)];
        match random.usize(..6) {
            0 | 1 => Condition::Defined(name),
            2 => Condition::Undefined(name),
            3 => Condition::Both(name, MACROS[random.usize(..4)]),
            _ => Condition::MoreLights(random.usize(..4) as u64),
        }
    }

    fn text(&self) -> String {
        match self {
            Condition::Defined(name) => format!("#ifdef {name}"),
            Condition::Undefined(name) => format!("#ifndef {name}"),
            Condition::Both(a, b) => format!("#if defined({a}) && !defined({b})"),
            Condition::MoreLights(n) => format!("#if LIGHTS > {n}"),
        }
    }

    fn holds(&self, set: &Set) -> bool {
        let is_set = |name: &str| set.iter().any(|(other, _)| other == name);
        match self {
            Condition::Defined(name) => is_set(name),
            Condition::Undefined(name) => !is_set(name),
            Condition::Both(a, b) => is_set(a) && !is_set(b),
            Condition::MoreLights(n) => {
                let lights = set.iter().find(|(name, _)| name == "LIGHTS");
                lights.is_some_and(|(_, text)| text.parse::<u64>().expect("a number") > *n)
            }
        }
    }
}

#[derive(Clone)]
struct Member {
    name: String,
    ty: usize,
    condition: Option<Condition>,
}

#[derive(Clone)]
enum Item {
    /// Two blocks of one name are never in one variant.
    Block {
        name: String,
        members: Vec<Member>,
    },
    If {
        condition: Condition,
        then: Vec<Item>,
        otherwise: Vec<Item>,
    },
}

/// Name and type of the members of each block, with offsets.
type Blocks = BTreeMap<String, Vec<(String, &'static str, u64)>>;

fn block(random: &mut Rng, name: String) -> Item {
    let count = 2 + random.usize(..4);
    let member = |at| Member {
        name: format!("m{at}"),
        ty: random.usize(..TYPES.len()),
        // The first stays: a block has a member in each variant.
        condition: (at > 0 && random.usize(..5) == 0).then(|| Condition::random(random)),
    };
    Item::Block { name, members: (0..count).map(member).collect() }
}

fn items(random: &mut Rng, depth: usize, names: &mut usize) -> Vec<Item> {
    let count = 1 + random.usize(..3);
    (0..count)
        .map(|_| {
            *names += 1;
            let name = format!("B{names}");
            if depth == 0 || random.usize(..3) == 0 {
                return block(random, name);
            }
            let condition = Condition::random(random);
            if random.usize(..4) == 0 {
                let (then, otherwise) = (block(random, name.clone()), block(random, name));
                return Item::If { condition, then: vec![then], otherwise: vec![otherwise] };
            }
            let then = items(random, depth - 1, names);
            let otherwise = match random.usize(..2) {
                0 => Vec::new(),
                _ => items(random, depth - 1, names),
            };
            Item::If { condition, then, otherwise }
        })
        .collect()
}

fn print(items: &[Item], text: &mut String) {
    for item in items {
        match item {
            Item::Block { name, members } => {
                let _ = writeln!(text, "layout(std140) uniform {name} {{");
                for member in members {
                    let line = format!("    {} {name}_{};", TYPES[member.ty].0, member.name);
                    let _ = match &member.condition {
                        None => writeln!(text, "{line}"),
                        Some(condition) => writeln!(text, "{}\n{line}\n#endif", condition.text()),
                    };
                }
                text.push_str("};\n");
            }
            Item::If { condition, then, otherwise } => {
                let _ = writeln!(text, "{}", condition.text());
                print(then, text);
                if !otherwise.is_empty() {
                    text.push_str("#else\n");
                    print(otherwise, text);
                }
                text.push_str("#endif\n");
            }
        }
    }
}

fn text_of(items: &[Item]) -> String {
    let mut text = String::from("#version 330 core\n");
    print(items, &mut text);
    text.push_str("void main() {}\n");
    text
}

/// The blocks of a variant.
fn expected(items: &[Item], set: &Set, blocks: &mut Blocks) {
    for item in items {
        match item {
            Item::Block { name, members } => {
                let there =
                    members.iter().filter(|m| m.condition.as_ref().is_none_or(|c| c.holds(set)));
                let mut end = 0u64;
                let placed = there.map(|member| {
                    let (ty, align, size) = TYPES[member.ty];
                    let offset = end.next_multiple_of(align);
                    end = offset + size;
                    (format!("{name}_{}", member.name), ty, offset)
                });
                let placed = placed.collect();
                assert!(blocks.insert(name.clone(), placed).is_none(), "{name} twice");
            }
            Item::If { condition, then, otherwise } => {
                expected(if condition.holds(set) { then } else { otherwise }, set, blocks);
            }
        }
    }
}

fn blocks_of(items: &[Item], set: &Set) -> Blocks {
    let mut blocks = Blocks::new();
    expected(items, set, &mut blocks);
    blocks
}

fn sets(random: &mut Rng) -> Vec<Set> {
    let one = |_| {
        let chosen = MACROS.iter().filter(|_| random.usize(..2) == 0);
        let mut set: Set = chosen.map(|name| (name.to_string(), "1".to_string())).collect();
        for (name, text) in &mut set {
            if name == "LIGHTS" {
                *text = ["1", "2", "4"][random.usize(..3)].to_string();
            }
        }
        set
    };
    let mut sets: Vec<Set> = (0..4).map(one).collect();
    sets.retain(|set| !set.is_empty());
    sets.sort();
    sets.dedup();
    sets
}

fn laid_out(text: &str, sets: &[Set]) -> ShaderLayout {
    let (source, options) = (Source::new("a.frag", text), Options::default());
    let shader = layout(&source, &options).with_variants(&source, &options, sets);
    assert!(!shader.has_errors(), "{text}\n{:?}", shader.diagnostics);
    shader
}

/// The blocks that a lock gives a variant, read from its JSON.
fn locked(lock: &Value, set: &Set) -> Blocks {
    let spelled = |(name, text): &(String, String)| match text.as_str() {
        "1" => Value::from(name.as_str()),
        text => Value::from(format!("{name}={text}")),
    };
    let set: Value = set.iter().map(spelled).collect::<Vec<_>>().into();
    let has = |list: &Value, set: &Value| list.as_array().is_some_and(|list| list.contains(set));
    // A set that the lock does not list gives what none gives.
    let set = if has(&lock["variants"], &set) { set } else { Value::Array(Vec::new()) };
    let all = lock["blocks"].as_array().expect("a list").iter();
    let ours = all.filter(|block| block.get("variants").is_none_or(|list| has(list, &set)));
    let mut blocks = Blocks::new();
    for block in ours {
        let members = block["members"].as_array().expect("a list").iter().map(|member| {
            let text = |key: &str| member[key].as_str().expect("a text").to_string();
            let ty = TYPES.iter().find(|ty| ty.0 == text("type")).expect("one of these").0;
            (text("name"), ty, member["offset"].as_u64().expect("a number"))
        });
        let name = block["name"].as_str().expect("a text").to_string();
        assert!(blocks.insert(name, members.collect()).is_none(), "{block} twice in {set}");
    }
    blocks
}

/// Swaps two members of the block of this number; whether there is one.
fn swap(items: &mut [Item], number: &mut usize, random: &mut Rng) -> Option<String> {
    for item in items {
        match item {
            Item::Block { name, members } => {
                if *number == 0 {
                    let (a, b) = (random.usize(..members.len()), random.usize(..members.len()));
                    members.swap(a, b);
                    return Some(name.clone());
                }
                *number -= 1;
            }
            Item::If { then, otherwise, .. } => {
                let found = swap(then, number, random).or_else(|| swap(otherwise, number, random));
                if found.is_some() {
                    return found;
                }
            }
        }
    }
    None
}

/// Whether the findings say that a block changed under a set of macros.
fn names_set(found: &[Finding], block: &str, set: &Set) -> bool {
    let name = variant_name(set);
    found.iter().any(|finding| {
        finding.message.starts_with(&format!("`{block}` under `{name}` differs"))
            || finding.message.starts_with(&format!("`{block}` under `"))
                && finding.notes.contains(&format!("the same under `{name}`"))
    })
}

#[test]
fn every_block_of_every_variant_is_locked_once_and_guarded() {
    let (mut variants, mut blocks, mut moved, mut hidden) = (0, 0, 0, 0);
    for seed in sample(0..SHADERS, 6) {
        let random = &mut Rng::with_seed(seed);
        let tree = items(random, 3, &mut 0);
        let sets = sets(random);
        let text = text_of(&tree);
        let shader = laid_out(&text, &sets);
        let written = lock::write(&shader);
        let json: Value = serde_json::from_str(&written).expect("a lock is JSON");
        let base = Set::new();
        for set in std::iter::once(&base).chain(&sets) {
            let wanted = blocks_of(&tree, set);
            assert_eq!(locked(&json, set), wanted, "{seed} {set:?}\n{text}\n{written}");
            blocks += wanted.len();
            variants += 1;
        }
        let all = json["blocks"].as_array().expect("a list").iter().cloned();
        let mut all: Vec<String> = all
            .map(|mut block| {
                block.as_object_mut().expect("an object").remove("variants");
                block.to_string()
            })
            .collect();
        let count = all.len();
        all.sort();
        all.dedup();
        assert_eq!(all.len(), count, "{seed}: a block is written twice\n{written}");
        let lock = lock::read("layouts/a.frag.json", &written).expect("it was written just now");
        assert_eq!(lock.text(), written, "{seed}: it is read as it was written");
        assert_eq!(drift(&shader, "layouts/a.frag.json", Some(&lock)), [], "{seed}\n{text}");
        for number in 0.. {
            let mut changed = tree.clone();
            let Some(name) = swap(&mut changed, &mut { number }, random) else { break };
            let differs = |set: &Set| blocks_of(&tree, set) != blocks_of(&changed, set);
            let now = laid_out(&text_of(&changed), &sets);
            let found = drift(&now, "layouts/a.frag.json", Some(&lock));
            let shown: Vec<&Set> = sets.iter().filter(|set| differs(set)).collect();
            assert_eq!(
                found.is_empty(),
                shown.is_empty() && !differs(&base),
                "{seed} {name}\n{text}\n{found:#?}"
            );
            for set in &sets {
                let is_named = names_set(&found, &name, set);
                assert!(differs(set) || !is_named, "{seed} {name} {set:?} is unchanged\n{text}");
                // What the shader shows without macros is not repeated for each set.
                assert!(
                    differs(&base) || is_named == differs(set),
                    "{seed} {name} {set:?}\n{text}"
                );
            }
            if differs(&base) {
                let plain = format!("`{name}` differs from its lock");
                assert!(found.iter().any(|f| f.message.starts_with(&plain)), "{found:#?}");
            }
            moved += usize::from(!found.is_empty());
            hidden += usize::from(!differs(&base) && !shown.is_empty());
        }
    }
    println!(
        "{variants} variants, {blocks} blocks; {moved} moves found, {hidden} in variants only"
    );
    let share = if everything() { 1 } else { 12 };
    assert!(
        blocks * share > 3000 && moved * share > 1000 && hidden * share > 200,
        "{blocks} {moved} {hidden}"
    );
}

#[test]
fn a_lock_of_version_1_has_no_variants_and_is_compared_with_the_shader_as_it_is() {
    let set = vec![("FOG".to_string(), "1".to_string())];
    let text = "#version 330 core\n#ifdef FOG\nlayout(std140) uniform Fog { vec3 fog; };\n#endif\n\
                layout(std140) uniform V { vec4 c; };\nvoid main() {}\n";
    let old = lock::write(&laid_out(text, &[]));
    assert!(old.contains("\"schema_version\": 1,"), "{old}");
    let lock = lock::read("layouts/a.frag.json", &old).expect("a lock");
    let found = drift(&laid_out(text, &[set]), "layouts/a.frag.json", Some(&lock));
    let said: Vec<&str> = found.iter().map(|finding| finding.message.as_str()).collect();
    assert_eq!(
        said,
        [
            "`Fog` under `FOG` differs from its lock: block `Fog` is new, 16 bytes; buffers filled for it \
          are still read correctly, but the lock is out of date"
        ]
    );
}

#[test]
fn variants_of_a_lock_are_consistent_or_refused() {
    let sets = [vec![("FOG".to_string(), "1".to_string())]];
    let text = "#version 330 core\n#ifdef FOG\nlayout(std140) uniform Fog { vec3 fog; };\n#endif\n\
                layout(std140) uniform V { vec4 c; };\nvoid main() {}\n";
    let sound = lock::write(&laid_out(text, &sets));
    assert!(sound.contains("\"schema_version\": 2,"), "{sound}");
    let refused = |from: &str, to: &str| {
        let text = sound.replacen(from, to, 1);
        assert_ne!(text, sound, "{from}");
        lock::read("a.json", &text).expect_err("it contradicts itself").message
    };
    assert_eq!(
        refused("\"variants\": [[\"FOG\"]]", "\"variants\": [[\"FOGG\"]]"),
        "has a block of a variant that `variants` of the lock does not list, at line 22"
    );
    assert_eq!(
        refused("    [\"FOG\"]\n", "    [\"FOG\"], [\"FOG\"]\n"),
        "has the same macros twice in `variants`, at line 5"
    );
    assert_eq!(
        refused("\"name\": \"Fog\"", "\"name\": \"V\""),
        "contradicts itself at line 21: the block `V` is listed twice"
    );
}
