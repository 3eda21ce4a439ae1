#version 330 core
// One statement sets the rules for every uniform block below it, until the next.

layout(std140, row_major) uniform;

uniform RowBlock {
    mat3x4 bone;    // offset 0, size 64: four rows of three
    float weight;   // offset 64
} rows;

layout(column_major) uniform;

uniform ColumnBlock {
    mat3x4 bone;    // offset 0, size 48: three columns of four
    float weight;   // offset 48
} columns;

in vec3 position;
out vec4 color;

void main() {
    color = rows.bone * position * rows.weight + columns.bone * position * columns.weight;
}
