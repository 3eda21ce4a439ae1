#version 450
// Ambient, directional, point and spot lights in view space, in one std140 block.
//
// Attenuation is three floats, but std140 gives every struct an alignment and a size
// of whole 16s. That makes PointLight 48 bytes and SpotLight 64.
//
// Seed form: the formulas as a book prints them, with what is wrong with them. The ids
// H1, H2, ... are those of tests/hazards/; view_space/scene_450.frag is the form to use.

const int MAX_POINT_LIGHTS = 5;
const int MAX_SPOT_LIGHTS = 5;
const float SPECULAR_POWER = 10.0;

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

// pow(0, 0) where the material does not reflect and the light is beside the mirrored ray
// (H9); shines from behind the surface too (H13).
float highlight(vec3 toLight, vec3 normal, vec3 toEye, float reflectance)
{
    vec3 mirrored = normalize(reflect(-toLight, normal));
    float x = max(dot(toEye, mirrored), 0.0);
    return pow(x, reflectance > 0.0 ? SPECULAR_POWER : 0.0);
}

// (0, 0, 1) divides by zero on the light itself (H1b); the square overflows (H4).
float attenuation(float constant, float linear, float exponent, float d)
{
    return 1.0 / (constant + linear * d + exponent * d * d);
}

// With a cutoff of 1 every fragment whose cosine rounds past 1 is divided by zero (H8).
float cone(vec3 toLight, vec3 conedir, float cutoff)
{
    float x = dot(-toLight, normalize(conedir));
    if (x > cutoff)
    {
        return clamp((x - cutoff) / (1.0 - cutoff), 0.0, 1.0);
    }
    return 0.0;
}

vec4 calcAmbient(AmbientLight light, vec4 materialAmbient)
{
    return vec4(light.intensity * light.color, 1.0) * materialAmbient;
}

vec4 calcLightColor(Material mat, vec3 lightColor, float intensity, vec3 position, vec3 toLight, vec3 normal)
{
    vec3 toEye = normalize(cameraPosition - position); // none where the camera is (H2)
    float facing = max(dot(normal, toLight), 0.0);
    vec4 diffuse = mat.diffuse * vec4(lightColor, 1.0) * intensity * facing;
    vec4 specular = mat.specular * vec4(lightColor, 1.0) * intensity * highlight(toLight, normal, toEye, mat.reflectance);
    if (mat.reflectance <= 0.0)
    {
        specular = vec4(0.0);
    }
    return diffuse + specular;
}

// No direction where the light is on the fragment (H1).
vec4 calcPointLight(Material mat, PointLight light, vec3 position, vec3 normal)
{
    vec3 path = light.position - position;
    vec4 color = calcLightColor(mat, light.color, light.intensity, position, normalize(path), normal);
    return color * attenuation(light.att.constant, light.att.linear, light.att.exponent, length(path));
}

vec4 calcSpotLight(Material mat, SpotLight light, vec3 position, vec3 normal)
{
    vec3 toLight = normalize(light.pl.position - position);
    return calcPointLight(mat, light.pl, position, normal) * cone(toLight, light.conedir, light.cutoff);
}

vec4 calcDirLight(Material mat, DirLight light, vec3 position, vec3 normal)
{
    return calcLightColor(mat, light.color, light.intensity, position, normalize(light.direction), normal);
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

    vec3 normal = normalize(outNormal);
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
