#version 450
// Ambient, directional, point and spot lights in view space, in one std140 block.
//
// Attenuation is three floats, but std140 gives every struct an alignment and a size
// of whole 16s. That makes PointLight 48 bytes and SpotLight 64.

const int MAX_POINT_LIGHTS = 5;
const int MAX_SPOT_LIGHTS = 5;

layout(location = 0) in vec3 outPosition;
layout(location = 1) in vec3 outNormal;
layout(location = 2) in vec2 outTextCoord;

layout(location = 0) out vec4 fragColor;

struct Attenuation
{
    float constant; // offset 0
    float linear;   // offset 4
    float exponent; // offset 8, the factor of the squared distance; size 16 in std140
};

struct Material
{
    vec4 ambient;      // offset 0
    vec4 diffuse;      // offset 16
    vec4 specular;     // offset 32
    float reflectance; // offset 48, 0: no highlight; size 64 in all
};

struct AmbientLight
{
    float intensity; // offset 0, then a hole of 12 bytes
    vec3 color;      // offset 16
};

struct PointLight {
    vec3 position;   // offset 0
    vec3 color;      // offset 16
    float intensity; // offset 28, 0: an unused slot of the array
    Attenuation att; // offset 32, size 48 in all
};

struct SpotLight
{
    PointLight pl; // offset 0
    vec3 conedir;  // offset 48, the way the light travels
    float cutoff;  // offset 60, cosine of the cone's half angle; size 64 in all
};

struct DirLight
{
    vec3 color;      // offset 0
    vec3 direction;  // offset 16, towards the light
    float intensity; // offset 28
};

layout(std140, set = 0, binding = 1) uniform LightBlock {
    AmbientLight ambientLight;                // offset 0
    PointLight pointLights[MAX_POINT_LIGHTS]; // offset 32
    SpotLight spotLights[MAX_SPOT_LIGHTS];    // offset 272
    DirLight dirLight;                        // offset 592
    vec3 cameraPosition;                      // offset 624, in view space: the origin unless the host says otherwise
};

layout(std140, set = 1, binding = 0) uniform MaterialBlock {
    Material material; // offset 0
};

layout(set = 1, binding = 1) uniform sampler2D txtSampler;

// Unit vector along v; the zero vector stays zero.
vec3 unit(vec3 v)
{
    return v * inversesqrt(max(dot(v, v), 1.0e-30));
}

// Phong's highlight to the power 10. The eye is mirrored, not the light: that is the same
// for all lights of a fragment. 1 - cos is half the squared chord, which stays exact where
// the cosine is nearly 1, and squarings are cheaper than pow and defined at 0. A light
// behind the surface has no highlight.
float highlight(vec3 toLight, vec3 normal, vec3 toEye)
{
    vec3 chord = toLight - reflect(-toEye, normal);
    float x = dot(normal, toLight) > 0.0 ? max(1.0 - 0.5 * dot(chord, chord), 0.0) : 0.0;
    float x2 = x * x;
    float x4 = x2 * x2;
    return x4 * x4 * x2;
}

// 1 / (constant + linear d + exponent d^2), kept finite when nothing has been set yet.
float attenuation(float constant, float linear, float exponent, float d)
{
    return 1.0 / max(constant + d * (linear + exponent * d), 1.0e-4);
}

// 1 on the axis, falling to 0 at the cone, linear in the cosine.
float cone(vec3 toLight, vec3 conedir, float cutoff)
{
    vec3 chord = toLight + unit(conedir);
    float offAxis = 0.5 * dot(chord, chord); // 1 - cos, exact near the axis
    return max(1.0 - offAxis / max(1.0 - cutoff, 1.0e-9), 0.0);
}

vec4 calcAmbient(AmbientLight light, vec4 materialAmbient)
{
    return vec4(light.intensity * light.color, 1.0) * materialAmbient;
}

// Diffuse and specular reflection of a light without its attenuation.
vec4 calcLightColor(Material mat, vec3 lightColor, float intensity, vec3 position, vec3 toLight, vec3 normal)
{
    vec4 sum = mat.diffuse * max(dot(normal, toLight), 0.0);
    if (mat.reflectance > 0.0)
    {
        sum += mat.specular * highlight(toLight, normal, unit(cameraPosition - position));
    }
    return vec4(lightColor, 1.0) * intensity * sum;
}

vec4 calcPointLight(Material mat, PointLight light, vec3 position, vec3 normal)
{
    vec3 path = light.position - position;
    float d2 = dot(path, path);
    float inverse = inversesqrt(max(d2, 1.0e-30)); // one root for the direction and the distance
    float weakening = attenuation(light.att.constant, light.att.linear, light.att.exponent, d2 * inverse);
    return calcLightColor(mat, light.color, light.intensity, position, path * inverse, normal) * weakening;
}

// A point light inside a cone.
vec4 calcSpotLight(Material mat, SpotLight light, vec3 position, vec3 normal)
{
    float inside = cone(unit(light.pl.position - position), light.conedir, light.cutoff);
    if (inside <= 0.0)
    {
        return vec4(0.0);
    }
    return calcPointLight(mat, light.pl, position, normal) * inside;
}

vec4 calcDirLight(Material mat, DirLight light, vec3 position, vec3 normal)
{
    return calcLightColor(mat, light.color, light.intensity, position, unit(light.direction), normal);
}

void main()
{
    Material mat = material;
    vec4 texel = texture(txtSampler, outTextCoord);
    if (texel.a > 0.0) // a transparent texel means: no texture here
    {
        mat.ambient *= texel;
        mat.diffuse *= texel;
    }

    vec3 normal = unit(outNormal);
    vec4 sum = calcAmbient(ambientLight, mat.ambient);
    sum += calcDirLight(mat, dirLight, outPosition, normal);

    for (int i = 0; i < MAX_POINT_LIGHTS; i++)
    {
        if (pointLights[i].intensity > 0.0)
        {
            sum += calcPointLight(mat, pointLights[i], outPosition, normal);
        }
    }
    for (int i = 0; i < MAX_SPOT_LIGHTS; i++)
    {
        if (spotLights[i].pl.intensity > 0.0)
        {
            sum += calcSpotLight(mat, spotLights[i], outPosition, normal);
        }
    }

    fragColor = vec4(sum.rgb, mat.diffuse.a);
}
