//! Forms of modules that glslang does not write, assembled by `spirv-as`: the numbers expected are those
//! in the decorations of each text.

use landfall_layout::{AddressSpace, ArrayLen, Options, ShaderLayout, Source, Stage, layout};

use super::disassembly::tool;
use super::{bytes, laid_out, read};

/// The words of an assembly.
pub fn assembled(text: &str) -> Vec<u32> {
    let bytes = tool(
        "spirv-as",
        &["--preserve-numeric-ids", "--target-env", "spv1.5", "-", "-o", "-"],
        text.as_bytes(),
    );
    bytes.chunks_exact(4).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]])).collect()
}

/// A module of one uniform block `Block` whose structure is %10, with decorations and types of its
/// members, which begin at %20.
pub fn uniform(decorations: &str, types: &str, members: &str) -> String {
    format!(
        "OpCapability Shader
         OpMemoryModel Logical GLSL450
         OpEntryPoint Fragment %1 \"main\"
         OpExecutionMode %1 OriginUpperLeft
         OpName %10 \"Block\"
         OpDecorate %10 Block
         OpDecorate %12 DescriptorSet 2
         OpDecorate %12 Binding 7
         {decorations}
         %2 = OpTypeVoid
         %3 = OpTypeFunction %2
         %4 = OpTypeFloat 32
         %5 = OpTypeVector %4 3
         %6 = OpTypeVector %4 4
         %7 = OpTypeInt 32 0
         %8 = OpConstant %7 2
         {types}
         %10 = OpTypeStruct {members}
         %11 = OpTypePointer Uniform %10
         %12 = OpVariable %11 Uniform
         %1 = OpFunction %2 None %3
         %13 = OpLabel
         OpReturn
         OpFunctionEnd"
    )
}

/// Offsets of members of %10, one after another.
pub fn offsets(all: &[u32]) -> String {
    let one = |(member, offset): (usize, &u32)| {
        format!("OpMemberDecorate %10 {member} Offset {offset}\n")
    };
    all.iter().enumerate().map(one).collect()
}

/// Path, offset and strides.
type PlacedLeaf = (String, u64, Vec<u64>);

/// The rules, the size and the leaves of the only block.
fn block(shader: &ShaderLayout) -> (&'static str, u64, Vec<PlacedLeaf>) {
    let [block] = shader.blocks.as_slice() else { panic!("{:#?}", shader.blocks) };
    let leaf = |leaf: &landfall_layout::Leaf| {
        (leaf.path.clone(), leaf.offset.expect("it is placed"), leaf.strides.clone())
    };
    let leaves = block.leaves.iter().map(leaf).collect();
    (block.rules.name(), block.size.expect("it has bytes"), leaves)
}

fn rules_of(all: &[u32], decorations: &str, types: &str, members: &str) -> &'static str {
    let text = uniform(&format!("{}{decorations}", offsets(all)), types, members);
    block(&laid_out(&assembled(&text))).0
}

#[test]
fn the_rules_that_offsets_follow_are_found() {
    // A vec4, a float and a vec3.
    assert_eq!(rules_of(&[0, 16, 32], "", "", "%6 %4 %5"), "std140");
    // Offsets with gaps are those of `offset = N`.
    assert_eq!(rules_of(&[0, 32, 48], "", "", "%6 %4 %5"), "std140");
    // A float, a vec3 and a vec4: without gaps they are packed as in scalar.
    assert_eq!(rules_of(&[0, 4, 16], "", "", "%4 %5 %6"), "scalar");
    assert_eq!(rules_of(&[0, 4, 32], "", "", "%4 %5 %6"), "relaxed");
    // Two floats, which no std140 packs; scalar packs a vec3 over the end of 16 bytes.
    let floats = "%20 = OpTypeArray %4 %8";
    let tight = "OpDecorate %20 ArrayStride 4\n";
    assert_eq!(rules_of(&[0, 8], tight, floats, "%20 %4"), "std430");
    assert_eq!(rules_of(&[0, 8], tight, floats, "%20 %5"), "scalar");
    // In a constant buffer a float lies behind the last element, in the same register.
    let registers = "OpDecorate %20 ArrayStride 16\n";
    assert_eq!(rules_of(&[0, 20], registers, floats, "%20 %4"), "d3d");
    let by_columns = "%20 = OpTypeMatrix %5 3";
    let decorations = "OpMemberDecorate %10 0 ColMajor\nOpMemberDecorate %10 0 MatrixStride 16\n";
    assert_eq!(rules_of(&[0, 44], decorations, by_columns, "%20 %4"), "d3d");
    // A vec3 at 8 lies in two registers.
    assert_eq!(rules_of(&[0, 8], "", "", "%4 %5"), "scalar");
    assert_eq!(rules_of(&[0, 10], "", "", "%4 %5"), "explicit");
    let odd = "OpDecorate %20 ArrayStride 10\n";
    assert_eq!(rules_of(&[0, 16], odd, floats, "%20 %4"), "explicit");
}

#[test]
fn numbers_without_rules_are_taken_as_written() {
    let decorations = format!(
        "{}OpDecorate %20 ArrayStride 20
         OpMemberDecorate %10 2 MatrixStride 28
         OpMemberDecorate %10 2 RowMajor
         OpMemberName %10 0 \"far\"
         OpMemberName %10 1 \"spread\"
         OpMemberName %10 2 \"turn\"",
        offsets(&[100, 4, 200])
    );
    let types = "%20 = OpTypeArray %4 %8\n%21 = OpTypeMatrix %5 4";
    let shader = laid_out(&assembled(&uniform(&decorations, types, "%4 %20 %21")));
    let (rules, size, leaves) = block(&shader);
    assert_eq!(rules, "explicit");
    // Three rows of four floats, 28 bytes apart: the last ends at 200 + 2 * 28 + 16.
    assert_eq!(size, 272);
    assert_eq!(
        leaves,
        [
            ("far".to_string(), 100, vec![]),
            ("spread[]".to_string(), 4, vec![20]),
            ("turn".to_string(), 200, vec![]),
        ]
    );
    let turn = &shader.blocks[0].leaves[2];
    assert_eq!((turn.matrix_stride, turn.row_major, turn.size), (Some(28), true, Some(72)));
    assert_eq!((shader.blocks[0].group, shader.blocks[0].binding), (Some(2), Some(7)));
    assert_eq!(shader.stage, Some(Stage::Fragment));
    // Every byte is a component's or padding.
    let padding: u64 = landfall_layout::layout::padding::padding(&shader.blocks[0])
        .iter()
        .map(|p| p.size * p.times)
        .sum();
    assert_eq!(padding + shader.blocks[0].used(), 272);
}

#[test]
fn both_byte_orders_are_read() {
    let words = assembled(&uniform(&offsets(&[0, 16]), "", "%6 %4"));
    let big: Vec<u8> = words.iter().flat_map(|word| word.to_be_bytes()).collect();
    // Whatever it is called.
    let source = Source::from_bytes("shader.bin", big).expect("it has the magic number");
    let (big, little) = (layout(&source, &Options::default()), laid_out(&words));
    assert_eq!(block(&big), block(&little));
    assert_eq!(block(&big).0, "std140");
}

#[test]
fn stripped_modules_have_numbers_for_names() {
    let text = uniform(
        &format!(
            "{}OpDecorate %21 ArrayStride 16\nOpMemberDecorate %20 0 Offset 0",
            offsets(&[0, 16])
        ),
        "%20 = OpTypeStruct %4\n%21 = OpTypeArray %20 %8",
        "%6 %21",
    );
    let text = text.replace("OpName %10", "OpName %20 \"Light\"\nOpName %10");
    let stripped = tool("spirv-opt", &["--strip-debug", "-", "-o", "-"], &bytes(&assembled(&text)));
    let source = Source::from_bytes("a.spv", stripped).expect("it is a module");
    let shader = layout(&source, &Options::default());
    assert_eq!(&*shader.blocks[0].name, "block_10");
    assert_eq!(shader.blocks[0].instance, None);
    let paths: Vec<&str> = shader.blocks[0].leaves.iter().map(|leaf| leaf.path.as_str()).collect();
    assert_eq!(paths, ["member_0", "member_1[].member_0"]);
}

#[test]
fn names_become_identifiers_of_their_own() {
    let names = "OpName %10 \"type.StructuredBuffer.Light\"
         OpMemberName %10 0 \"2d\"
         OpMemberName %10 1 \"a\"
         OpMemberName %10 2 \"a\"
         OpMemberName %10 3 \"a.b c\"
         OpMemberName %10 4 \"$$\"
         OpName %12 \"lights\"";
    let text = uniform(&format!("{}{names}", offsets(&[0, 4, 8, 12, 16])), "", "%4 %4 %4 %4 %4");
    let shader = laid_out(&assembled(&text.replace("OpName %10 \"Block\"", "")));
    let members: Vec<&str> = shader.blocks[0].members.iter().map(|member| &*member.name).collect();
    assert_eq!(members, ["_2d", "a", "a_2", "a_b_c", "member_4"]);
    assert_eq!(&*shader.blocks[0].name, "Light");
    assert_eq!(shader.blocks[0].instance.as_deref(), Some("lights"));
}

#[test]
fn lengths_are_computed_from_specialisation_constants() {
    // (COUNT + 1) * 2 - (COUNT < 9 ? 1 : 0), by COUNT = 4.
    let types = "%30 = OpTypeBool
         %31 = OpSpecConstant %7 4
         %32 = OpConstant %7 1
         %33 = OpConstant %7 9
         %34 = OpConstant %7 0
         %35 = OpSpecConstantOp %7 IAdd %31 %32
         %36 = OpSpecConstantOp %7 IMul %35 %8
         %37 = OpSpecConstantOp %30 ULessThan %31 %33
         %38 = OpSpecConstantOp %7 Select %37 %32 %34
         %39 = OpSpecConstantOp %7 ISub %36 %38
         %20 = OpTypeArray %6 %39";
    let decorations = format!(
        "{}OpDecorate %20 ArrayStride 16\nOpDecorate %31 SpecId 3\nOpName %31 \"COUNT\"",
        offsets(&[0])
    );
    let words = assembled(&uniform(&decorations, types, "%20"));
    let shader = laid_out(&words);
    assert_eq!(shader.blocks[0].leaves[0].dims, [ArrayLen::Fixed(9)]);
    let one = &shader.overrides[0];
    assert_eq!((&*one.name, one.id, one.value), ("COUNT", Some(3), Some(4)));
    assert_eq!(shader.specialised[0].given, None);
    for (key, value, given) in [("COUNT", "10", Some(22)), ("3", "1", Some(3)), ("9", "1", None)] {
        let mut options = Options::default();
        options.read.overrides = vec![(key.to_string(), value.to_string())];
        let source = Source::from_bytes("a.spv", bytes(&words)).expect("it is a module");
        let shader = layout(&source, &options);
        // Specialisation does not lay a block out anew.
        assert_eq!(shader.blocks[0].leaves[0].dims, [ArrayLen::Fixed(9)], "{key}");
        assert_eq!(shader.specialised[0].given, given, "{key}");
    }
    let mut options = Options::default();
    options.read.overrides = vec![("COUNT".to_string(), "many".to_string())];
    let source = Source::from_bytes("a.spv", bytes(&words)).expect("it is a module");
    let messages: Vec<String> =
        layout(&source, &options).diagnostics.into_iter().map(|found| found.message).collect();
    assert_eq!(messages, ["`COUNT` is set to `many`, which is not a value of its type"]);
}

#[test]
fn blocks_are_told_apart_by_storage_class() {
    let of = |decoration: &str, class: &str| {
        let text = uniform(&offsets(&[0]), "", "%6");
        let text = text.replace("OpDecorate %10 Block", &format!("OpDecorate %10 {decoration}"));
        let text = text.replace("OpTypePointer Uniform", &format!("OpTypePointer {class}"));
        let text = text.replace("%11 Uniform", &format!("%11 {class}"));
        laid_out(&assembled(&text)).blocks.first().map(|block| block.space)
    };
    assert_eq!(of("Block", "Uniform"), Some(AddressSpace::Uniform));
    assert_eq!(of("BufferBlock", "Uniform"), Some(AddressSpace::Storage));
    assert_eq!(of("Block", "StorageBuffer"), Some(AddressSpace::Storage));
    assert_eq!(of("Block", "PushConstant"), Some(AddressSpace::PushConstant));
    assert_eq!(of("Block", "ShaderRecordBufferKHR"), Some(AddressSpace::ShaderRecord));
    assert_eq!(of("Block", "TaskPayloadWorkgroupEXT"), Some(AddressSpace::TaskPayload));
    assert_eq!(of("Block", "Output"), None);
}

#[test]
fn pointees_of_physical_storage_are_blocks() {
    let text = "OpCapability Shader
         OpCapability PhysicalStorageBufferAddresses
         OpExtension \"SPV_KHR_physical_storage_buffer\"
         OpMemoryModel PhysicalStorageBuffer64 GLSL450
         OpName %10 \"Node\"
         OpMemberName %10 0 \"next\"
         OpMemberName %10 1 \"value\"
         OpName %20 \"Head\"
         OpMemberName %20 0 \"first\"
         OpDecorate %10 Block
         OpMemberDecorate %10 0 Offset 0
         OpMemberDecorate %10 1 Offset 8
         OpDecorate %20 Block
         OpMemberDecorate %20 0 Offset 0
         OpTypeForwardPointer %11 PhysicalStorageBuffer
         %4 = OpTypeFloat 32
         %10 = OpTypeStruct %11 %4
         %11 = OpTypePointer PhysicalStorageBuffer %10
         %20 = OpTypeStruct %11
         %21 = OpTypePointer PushConstant %20
         %22 = OpVariable %21 PushConstant";
    let shader = laid_out(&assembled(text));
    let told: Vec<String> = shader
        .blocks
        .iter()
        .flat_map(|block| {
            let of = format!("{} {}", block.space.name(), block.name);
            let leaf = move |leaf: &landfall_layout::Leaf| {
                let ty = leaf.ty.spelled(landfall_layout::Language::SpirV);
                format!("{of}.{} {ty} {:?}", leaf.path, leaf.offset)
            };
            block.leaves.iter().map(leaf).collect::<Vec<_>>()
        })
        .collect();
    assert_eq!(
        told,
        [
            "push_constant Head.first Node Some(0)",
            "buffer_reference Node.next Node Some(0)",
            "buffer_reference Node.value float Some(8)",
        ]
    );
}

#[test]
fn groups_of_decorations_are_those_of_their_targets() {
    let decorations = "OpDecorate %40 ArrayStride 32
         %40 = OpDecorationGroup
         OpGroupDecorate %40 %20
         OpDecorate %41 Offset 16
         %41 = OpDecorationGroup
         OpMemberDecorate %10 0 Offset 0
         OpGroupMemberDecorate %41 %10 1";
    let text = uniform(decorations, "%20 = OpTypeArray %6 %8", "%6 %20");
    let leaves = block(&laid_out(&assembled(&text))).2;
    assert_eq!(leaves[1], ("member_1[]".to_string(), 16, vec![32]));
}

#[test]
fn arrays_of_blocks_and_runtime_tails_have_their_dimensions() {
    let text = uniform(
        &format!("{}OpDecorate %20 ArrayStride 16", offsets(&[0, 16])),
        "%20 = OpTypeRuntimeArray %5",
        "%6 %20",
    );
    let text = text.replace(
        "%11 = OpTypePointer Uniform %10",
        "%14 = OpTypeArray %10 %8\n%15 = OpTypeRuntimeArray %14\n%11 = OpTypePointer StorageBuffer %15",
    );
    let text = text.replace("%11 Uniform", "%11 StorageBuffer");
    let shader = laid_out(&assembled(&text));
    assert_eq!(shader.blocks[0].count, [ArrayLen::Runtime, ArrayLen::Fixed(2)]);
    assert_eq!(shader.blocks[0].leaves[1].dims, [ArrayLen::Runtime]);
    assert_eq!((shader.blocks[0].rules.name(), shader.blocks[0].size), ("std430", Some(32)));
}

#[test]
fn other_rules_lay_a_module_out_anew() {
    let words = assembled(&uniform(&offsets(&[100, 4]), "", "%5 %4"));
    let source = Source::from_bytes("a.spv", bytes(&words)).expect("it is a module");
    let options = Options::default().with_rules(Some(landfall_layout::Rules::Std140));
    let (rules, size, leaves) = block(&layout(&source, &options));
    assert_eq!((rules, size), ("std140", 16));
    assert_eq!([leaves[0].1, leaves[1].1], [0, 12]);
    assert!(read(&words).diagnostics.is_empty());
}
