//! Every block of two members, numbered. `blocks` prints them.

use std::rc::Rc;

use super::blocks::{
    Basic, Block, Dim, Major, Member, Rules, Scalar, Space, Spelling, Struct, Type,
};

/// Every block of two members: all scalars, vectors and matrices of float,
/// int, uint, bool and double, each matrix in both orders, and structures of
/// one scalar, one vec3 and one dvec3; each alone, as `[1]` and as `[2]`; in
/// both orders. std140 is uniform, std430 and scalar are buffers. They are
/// numbered from 0 to `pair_count`.
pub fn pairs(rules: Rules, numbers: &[u64]) -> Vec<Block> {
    let all = pair_members();
    numbers
        .iter()
        .map(|&number| {
            let number = number as usize;
            let mut first = all[number / all.len()].clone();
            let mut second = all[number % all.len()].clone();
            "m0".clone_into(&mut first.name);
            "m1".clone_into(&mut second.name);
            Block {
                name: format!("B{number}"),
                space: if rules == Rules::Std140 { Space::Uniform } else { Space::Buffer },
                rules,
                rules_written: true,
                major: None,
                align: None,
                instance: Some(format!("b{number}")),
                count: None,
                members: vec![first, second],
            }
        })
        .collect()
}

pub fn pair_count() -> u64 {
    pair_members().len().pow(2) as u64
}

fn pair_members() -> Vec<Member> {
    let mut kinds: Vec<(Type, Option<Major>)> = Vec::new();
    let basic = |scalar, columns, rows| Type::Basic(Basic { scalar, columns, rows });
    for scalar in [Scalar::Float, Scalar::Int, Scalar::Uint, Scalar::Bool, Scalar::Double] {
        kinds.extend((1..5).map(|rows| (basic(scalar, 1, rows), None)));
    }
    for scalar in [Scalar::Float, Scalar::Double] {
        for columns in 2..5 {
            for rows in 2..5 {
                kinds.push((basic(scalar, columns, rows), None));
                kinds.push((basic(scalar, columns, rows), Some(Major::Row)));
            }
        }
    }
    for (name, scalar, rows) in
        [("One", Scalar::Float, 1), ("Three", Scalar::Float, 3), ("WideThree", Scalar::Double, 3)]
    {
        let members = vec![Member::plain("s0", basic(scalar, 1, rows))];
        kinds.push((Type::Struct(Rc::new(Struct { name: name.to_owned(), members })), None));
    }
    let mut all = Vec::new();
    for (ty, major) in kinds {
        for length in [None, Some(1), Some(2)] {
            let mut member = Member::plain("", ty.clone());
            member.major = major;
            member
                .name_dims
                .extend(length.map(|n| Dim { length: Some(n), spelling: Spelling::Decimal }));
            all.push(member);
        }
    }
    all
}
