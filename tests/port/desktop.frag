#version 120
// Before blocks, before `in` and `out`.
uniform sampler2DShadow map;
uniform samplerCube sky;
uniform sampler2D flat, buffer;
uniform mat3x2 bend;
uniform bvec3 parts;
uniform vec4 tint[2];
varying vec3 shade;
varying vec4 shadow_at;

float lit() { return shadow2DProj(map, shadow_at).r; }

void main()
{
	vec2 uv = bend * shade;
	vec4 color = texture2D(flat, uv) * (parts.y ? tint[1] : tint[0]);
	gl_FragData[0] = color * lit() + textureCube(sky, shade);
	gl_FragData[1] = texture2DLod(buffer, uv, 0.0); // second target
}
