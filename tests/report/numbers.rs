//! The numbers of the maps: against the JSON of `layout` and the answers of `explain`, for every
//! block of the shaders here, under all rules.

use std::collections::BTreeMap;

use landfall_layout::layout::byte::{ByteOwner, owner_of_byte};
use landfall_layout::layout::explain::explain;
use landfall_layout::{BlockLayout, Options, ShaderLayout, Source, layout};
use serde_json::{Value, json};

use crate::browser::Browser;
use crate::support::{DRAW_ALL, Folder, json as output_json, of_views, output, repository};

/// Every cell that a map shows, by the path of its shader and the index of its block.
const CELLS: &str = "view => ({
    shader: view.shader.path, block: view.shader.blocks.indexOf(view.block), name: view.block.name,
    cells: [...view.element.querySelectorAll('button.cell:not(.pad)')].map(cell => ({
        path: cell.dataset.path, type: cell.dataset.type,
        offset: Number(cell.dataset.offset), size: Number(cell.dataset.size),
        text: cell.querySelector('.type i').textContent,
        columns: [...cell.parentElement.children].indexOf(cell) < 0 ? '' : cell.style.gridColumn,
    })),
    pads: [...view.element.querySelectorAll('button.pad')].map(cell => ({
        offset: Number(cell.dataset.offset), size: Number(cell.dataset.size), kind: cell.dataset.padding,
    })),
})";

/// A page of every shader here, with all maps drawn.
fn all_shaders(browser: &Browser, folder: &Folder) {
    let page = folder.path().join("all.html");
    output(repository(), 0, &["report", "shaders", "--out", page.to_str().unwrap()]);
    browser.open(&page);
    browser.run(DRAW_ALL, &[]);
}

/// The places that an array of JSON's `dims` and `strides` has in a map: the offsets of all its
/// elements up to four, else of the first two and the last.
fn shown_offsets(base: u64, dims: &[Value], strides: &[Value]) -> Vec<u64> {
    let Some((len, rest)) = dims.split_first() else { return vec![base] };
    let stride = strides[0].as_u64().unwrap();
    let indices: Vec<u64> = match len.as_u64() {
        Some(len) if len <= 4 => (0..len).collect(),
        Some(len) => vec![0, 1, len - 1],
        // Of a runtime-sized array, one element is certain.
        None => vec![0],
    };
    indices.iter().flat_map(|i| shown_offsets(base + i * stride, rest, &strides[1..])).collect()
}

/// The cells that a map has for a leaf of the JSON: offset and size of each vector.
fn cells_of_leaf(leaf: &Value) -> Vec<(u64, u64)> {
    let number = |key: &str| leaf[key].as_u64();
    let list = |key: &str| leaf[key].as_array().cloned().unwrap_or_default();
    let starts = shown_offsets(number("offset").unwrap(), &list("dims"), &list("strides"));
    let size = number("size").unwrap();
    let Some(stride) = number("matrix_stride") else {
        return starts.into_iter().map(|start| (start, size)).collect();
    };
    // `mat3x2`, `dmat4`, `mat3x2<f32>`: columns, rows and the width of a component.
    let ty = leaf["type"].as_str().unwrap();
    let size_of = &ty[ty.find("mat").unwrap() + 3..];
    let digits: Vec<u64> =
        size_of.split(['x', '<']).take(2).filter_map(|part| part.parse().ok()).collect();
    let (columns, rows) = (digits[0], *digits.get(1).unwrap_or(&digits[0]));
    let width = match (ty.starts_with('d') || ty.contains("f64"), ty.contains("f16")) {
        (true, _) => 8,
        (_, true) => 2,
        _ => 4,
    };
    let row_major = leaf["row_major"] == json!(true);
    let (count, length) = if row_major { (rows, columns) } else { (columns, rows) };
    let vectors = |start: u64| (0..count).map(move |i| (start + i * stride, length * width));
    starts.into_iter().flat_map(vectors).collect()
}

#[test]
fn the_cells_have_the_numbers_of_the_json_for_every_block_of_the_shaders_here() {
    let (browser, folder) = (Browser::start("numbers"), Folder::new("numbers"));
    all_shaders(&browser, &folder);
    let layouts = output_json(repository(), 0, &["layout", "shaders", "--format", "json"]);
    let mut blocks = BTreeMap::new();
    for shader in layouts["shaders"].as_array().unwrap() {
        for (index, block) in shader["blocks"].as_array().unwrap().iter().enumerate() {
            blocks.insert((shader["path"].as_str().unwrap().to_string(), index as u64), block);
        }
    }
    let views = of_views(&browser, CELLS);
    let views = views.as_array().unwrap();
    assert_eq!(views.len(), blocks.len());
    let mut cells = 0;
    for view in views {
        let key = (view["shader"].as_str().unwrap().to_string(), view["block"].as_u64().unwrap());
        let block = blocks[&key];
        assert_eq!(view["name"], block["name"], "{key:?}");
        if block["size"].is_null() {
            assert_eq!(view["cells"], json!([]), "{key:?}");
            continue;
        }
        let mut wanted: Vec<(u64, u64)> =
            block["leaves"].as_array().unwrap().iter().flat_map(cells_of_leaf).collect();
        let number = |cell: &Value, key: &str| cell[key].as_u64().unwrap();
        let shown = view["cells"].as_array().unwrap();
        for cell in shown {
            let text = cell["text"].as_str().unwrap();
            assert_eq!(text, number(cell, "offset").to_string());
            let first = number(cell, "offset") % 16;
            let end = (first + number(cell, "size")).min(16);
            assert_eq!(cell["columns"], json!(format!("{} / {}", first + 1, end + 1)), "{key:?}");
        }
        let mut found: Vec<(u64, u64)> =
            shown.iter().map(|cell| (number(cell, "offset"), number(cell, "size"))).collect();
        cells += found.len();
        wanted.sort_unstable();
        found.sort_unstable();
        assert_eq!(found, wanted, "{key:?}");
    }
    assert!(cells > 1000, "{cells}");
}

/// The shaders of this repository, laid out as the page has them.
fn laid_out(path: &str) -> ShaderLayout {
    let bytes = std::fs::read(repository().join(path)).unwrap();
    layout(&Source::from_bytes(path, bytes).unwrap(), &Options::default())
}

#[test]
fn the_padding_of_the_maps_is_what_no_component_has() {
    let (browser, folder) = (Browser::start("padding"), Folder::new("padding"));
    all_shaders(&browser, &folder);
    let views = of_views(&browser, CELLS);
    let mut shaders: BTreeMap<String, ShaderLayout> = BTreeMap::new();
    let mut pads = 0;
    for view in views.as_array().unwrap() {
        let path = view["shader"].as_str().unwrap();
        let shader = shaders.entry(path.to_string()).or_insert_with(|| laid_out(path));
        let block = &shader.blocks[view["block"].as_u64().unwrap() as usize];
        for pad in view["pads"].as_array().unwrap() {
            let (offset, size) = (pad["offset"].as_u64().unwrap(), pad["size"].as_u64().unwrap());
            for byte in offset..offset + size {
                match owner_of_byte(block, byte) {
                    ByteOwner::Padding { kind, .. } => assert_eq!(pad["kind"], json!(kind.name())),
                    other => panic!("{path} {} byte {byte}: {other:?}", block.name),
                }
            }
            pads += 1;
        }
        // And what has no cell within a row that has some belongs to folded elements.
        let shown: u64 = ["cells", "pads"]
            .iter()
            .flat_map(|key| view[key].as_array().unwrap())
            .map(|cell| cell["size"].as_u64().unwrap())
            .sum();
        if block.leaves.iter().all(|leaf| leaf.dims.is_empty()) {
            assert_eq!(shown, block.size.unwrap_or(0), "{path} {}", block.name);
        }
    }
    assert!(pads > 100, "{pads}");
}

/// The answers of the byte field and the chains of the panel, for every block and all rules.
const ANSWERS: &str = "
    const [most] = arguments;
    const found = [];
    for (const { view } of document.querySelectorAll('article.block')) {
        if (view.own.size === null) continue;
        for (const layout of view.block.layouts) {
            const button = view.element.querySelector(`[data-rules=${layout.rules}]`);
            if (button.getAttribute('aria-pressed') === 'false') button.click();
        }
        for (const layout of view.block.layouts) {
            view.state.opened.clear();
            const field = view.element.querySelector('input.byte');
            const bytes = [];
            const step = Math.max(1, Math.floor(layout.size / most));
            const chains = {};
            for (let byte = 0; byte < layout.size + step; byte += step) {
                field.value = String(byte);
                field.dispatchEvent(new Event('input'));
                const index = [...view.rules].length > 1
                    ? view.block.layouts.filter(one => view.rules.has(one.rules)).indexOf(layout) : 0;
                bytes.push([byte, view.output.querySelectorAll('p')[index].textContent]);
                const map = view.element.querySelector(`.figure[data-rules=${layout.rules}]`);
                const cell = [...map.querySelectorAll('button.cell.found:not(.pad)')][0];
                if (!cell) continue;
                cell.focus();
                const panel = document.getElementById('detail');
                chains[cell.dataset.path] = [...panel.querySelectorAll('.chain li')].map(
                    item => [...item.querySelectorAll('p')].map(line => line.textContent));
            }
            found.push({ shader: view.shader.path, name: view.block.name,
                block: view.shader.blocks.indexOf(view.block), rules: layout.rules, bytes, chains });
        }
    }
    return found;";

/// What `landfall explain` prints for a byte, from its JSON-free parts.
fn byte_answer(block: &BlockLayout, shader: &ShaderLayout, byte: u64) -> String {
    use landfall_layout::format::Paint;
    use landfall_layout::format::explain::{Answer, text};
    let answer = Answer::Byte(byte, owner_of_byte(block, byte));
    let text = text(block, shader.language, &answer, Paint::Plain);
    let (_, wrapped) = text.split_once("\n\n").unwrap();
    wrapped.split_whitespace().collect::<Vec<&str>>().join(" ").replace('`', "")
}

/// The steps to a path as `landfall explain` prints them, a list of lines each.
fn chain(block: &BlockLayout, shader: &ShaderLayout, path: &str) -> Vec<Vec<String>> {
    use landfall_layout::format::Paint;
    use landfall_layout::format::explain::{Answer, text};
    let found = explain(block, path, shader.language).unwrap_or_else(|e| panic!("{path}: {e:?}"));
    let printed = text(block, shader.language, &Answer::Path(found), Paint::Plain);
    let mut steps: Vec<Vec<String>> = Vec::new();
    for line in printed.lines().skip(1).filter(|line| !line.is_empty()) {
        let indent = line.len() - line.trim_start().len();
        match indent {
            2 => steps.push(vec![line.trim().replace("  ", " ")]),
            _ => steps.last_mut().unwrap().push(line.trim().replace('`', "")),
        }
    }
    // The last line is the range.
    steps.pop();
    steps
}

#[test]
#[ignore = "draws for long in a browser: ./tests/run pages"]
fn bytes_and_chains_are_those_of_explain_under_all_rules() {
    let (browser, folder) = (Browser::start("answers"), Folder::new("answers"));
    let page = folder.path().join("some.html");
    let arguments = ["report", "shaders/ideas", "-o", page.to_str().unwrap()];
    output(repository(), 0, &arguments);
    browser.open(&page);
    let (mut answers, mut chains) = (0, 0);
    for found in browser.run(ANSWERS, &[json!(5)]).as_array().unwrap() {
        let path = found["shader"].as_str().unwrap();
        let rules = landfall_layout::Rules::from_name(found["rules"].as_str().unwrap());
        let bytes = std::fs::read(repository().join(path)).unwrap();
        let source = Source::from_bytes(path, bytes).unwrap();
        let shader = layout(&source, &Options::default().with_rules(rules));
        let block = &shader.blocks[found["block"].as_u64().unwrap() as usize];
        assert_eq!(json!(&*block.name), found["name"]);
        for answer in found["bytes"].as_array().unwrap() {
            let byte = answer[0].as_u64().unwrap();
            let told = answer[1].as_str().unwrap();
            let told = told
                .split_once(": byte")
                .map_or(told.to_string(), |(_, rest)| format!("byte{rest}"));
            assert_eq!(told.replace(',', ""), byte_answer(block, &shader, byte).replace(',', ""));
            answers += 1;
        }
        for (path, steps) in found["chains"].as_object().unwrap() {
            let steps: Vec<Vec<String>> = serde_json::from_value(steps.clone()).unwrap();
            assert_eq!(steps, chain(block, &shader, path), "{} {path}", block.name);
            chains += 1;
        }
    }
    assert!(answers > 500 && chains > 300, "{answers} {chains}");
}

#[test]
#[ignore = "draws for long in a browser: ./tests/run pages"]
fn a_block_of_thousands_of_members_is_shown_under_its_own_rules_and_answers_for_all() {
    let (browser, folder) = (Browser::start("large"), Folder::new("large"));
    let members: String = (0..5000).map(|i| format!(" float m{i};")).collect();
    folder.file("large.frag", format!("layout(std140) uniform Large {{{members} }};\n"));
    output(folder.path(), 0, &["report", "large.frag", "-o", "page.html"]);
    browser.open(&folder.path().join("page.html"));
    browser.run(DRAW_ALL, &[]);
    let shown = browser.run(
        "const field = document.querySelector('input.byte');
         field.value = '0x4e1d';
         field.dispatchEvent(new Event('input'));
         return [document.querySelectorAll('.rules button').length, document.querySelectorAll('.cell').length,
             document.querySelector('.map .note').textContent, document.querySelector('.who').textContent]",
        &[],
    );
    // 0x4e1d is 19997, byte 1 of the float at 4 × 4999.
    let wanted = "byte 19997 is byte 1 of 4 of m4999 (float m4999, bytes 19996 to 19999)";
    assert_eq!((&shown[0], &shown[1], &shown[3]), (&json!(1), &json!(4000), &json!(wanted)));
    assert!(shown[2].as_str().unwrap().contains("first 4,000 cells"), "{shown}");
}
