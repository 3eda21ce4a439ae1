// GLSL 1.10: no version at all.
attribute vec3 position, normal;
attribute vec2 uv;
uniform mat4 mvp;
varying vec3 shade;
varying vec4 shadow_at;
void main()
{
	shade = normal * 0.5 + 0.5;
	shadow_at = vec4(position * 0.5 + 0.5, 1.0);
	gl_Position = mvp * vec4(position, 1.0);
}
