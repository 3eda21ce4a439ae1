// Neovim with the lines that the book gives shows hints and findings. NVIM names the program.

import assert from "node:assert/strict";
import * as path from "node:path";
import { test } from "node:test";
import { editorSession } from "./client";

const nvim = process.env.NVIM_PROGRAM;

/** What is typed and asked: a member more in bytes that were padding. */
const typed = `
local function wait(what, holds)
  assert(vim.wait(30000, holds, 20), what .. " does not come")
end
local function labels()
  local found = {}
  for _, one in ipairs(vim.lsp.inlay_hint.get({ bufnr = 0 })) do
    found[one.inlay_hint.position.line + 1] = one.inlay_hint.label
  end
  return found
end
local function at(text)
  return vim.fn.search("\\\\V" .. text, "wc")
end
vim.cmd.edit("point_lights_450.frag")
wait("a hint", function() return labels()[at("vec3 pos")] ~= nil end)
local before = labels()[at("float quadratic")]
local pos = at("vec3 pos")
vim.api.nvim_buf_set_lines(0, pos, pos, false, { "    float radius;" })
wait("a finding", function() return #vim.diagnostic.get(0) > 0 end)
-- Until it has new hints, Neovim shows those it had, moved with their lines.
wait("the hint", function() return labels()[at("float radius")] == "@12" end)
local found = vim.diagnostic.get(0)[1]
vim.fn.search("uniform PointLightBlock", "wce")
vim.lsp.buf.code_action({
  apply = true,
  filter = function(one) return vim.startswith(one.title, "Write the mirror of") end,
})
local function mirror()
  local buffer = vim.fn.bufnr("point_light_block.rs")
  return buffer > 0 and table.concat(vim.api.nvim_buf_get_lines(buffer, 0, -1, false), "\\n") or ""
end
wait("the mirror", function() return #mirror() > 0 end)
vim.cmd.buffer("point_lights_450.frag")
io.stdout:write(vim.json.encode({
  before = before,
  radius = labels()[at("float radius")],
  array = labels()[at("PointLight data")],
  code = found.code,
  line = vim.fn.getline(found.lnum + 1),
  mirror = mirror(),
}))
vim.cmd("qa!")
`;

test("Neovim shows hints and a finding, and creates a mirror, with what the book gives", () => {
  assert(nvim !== undefined, "NVIM_PROGRAM names Neovim 0.11 or later");
  const found = editorSession("lua", { init: "init.lua", typed: "typed.lua" }, typed, (place) => ({
    command: nvim,
    args: ["--headless", "-u", path.join(place, "init.lua"), "-l", path.join(place, "typed.lua")],
    env: { XDG_STATE_HOME: place, XDG_DATA_HOME: place },
  }));
  // std140: pos is 12 bytes, so a float fits at 12 and the rest stays; an element is 48 bytes.
  assert.equal(found.radius, "@12");
  assert.match(found.before ?? "", /^@40\b/);
  assert.match(found.array ?? "", /^@0, stride 48$/);
  assert.equal(found.code, "layout-drift");
  assert.match(found.line ?? "", /PointLightBlock/);
  assert.match(found.mirror ?? "", /\/\/ landfall: mirror\(PointLightBlock\)\n/);
});
