#version 330
// Ambient, directional, point and spot lights in view space. Structs nest three
// deep, so that the host sets "spotLights[4].pl.att.exponent".

const int MAX_POINT_LIGHTS = 5;
const int MAX_SPOT_LIGHTS = 5;
const float SPECULAR_POWER = 10.0;

in vec3 outPosition;
in vec3 outNormal;
in vec2 outTextCoord;

out vec4 fragColor;

struct Attenuation
{
    float constant;
    float linear;
    float exponent; // the factor of the squared distance
};

struct Material
{
    vec4 ambient;
    vec4 diffuse;
    vec4 specular;
    float reflectance; // 0: no highlight
};

struct AmbientLight
{
    float intensity;
    vec3 color;
};

struct PointLight {
    vec3 position;
    vec3 color;
    float intensity; // 0: an unused slot of the array
    Attenuation att;
};

struct SpotLight
{
    PointLight pl;
    vec3 conedir; // the way the light travels
    float cutoff; // cosine of the cone's half angle
};

struct DirLight
{
    vec3 color;
    vec3 direction; // towards the light
    float intensity;
};

uniform sampler2D txtSampler;
uniform Material material;
uniform AmbientLight ambientLight;
uniform PointLight pointLights[MAX_POINT_LIGHTS];
uniform SpotLight spotLights[MAX_SPOT_LIGHTS];
uniform DirLight dirLight;
uniform vec3 cameraPosition; // in view space: the origin unless the host says otherwise

// Unit vector along v; the zero vector stays zero.
vec3 unit(vec3 v)
{
    return v * inversesqrt(max(dot(v, v), 1.0e-30));
}

// x to the power SPECULAR_POWER, by squaring: cheaper than pow and defined at 0.
float highlight(float x)
{
    float x2 = x * x;
    float x4 = x2 * x2;
    return x4 * x4 * x2;
}

vec4 calcAmbient(AmbientLight light, vec4 materialAmbient)
{
    return vec4(light.intensity * light.color, 1.0) * materialAmbient;
}

// Diffuse and specular reflection of a light without its attenuation.
vec4 calcLightColor(Material mat, vec3 lightColor, float intensity, vec3 position, vec3 toLight, vec3 normal)
{
    float facing = max(dot(normal, toLight), 0.0);
    vec4 sum = mat.diffuse * facing;
    if (mat.reflectance > 0.0)
    {
        vec3 toEye = unit(cameraPosition - position);
        sum += mat.specular * highlight(clamp(dot(toEye, reflect(-toLight, normal)), 0.0, 1.0));
    }
    return vec4(lightColor, 1.0) * intensity * sum;
}

vec4 calcPointLight(Material mat, PointLight light, vec3 position, vec3 normal)
{
    vec3 path = light.position - position;
    float d = length(path);
    float weakening = light.att.constant + d * (light.att.linear + light.att.exponent * d);
    return calcLightColor(mat, light.color, light.intensity, position, unit(path), normal)
         / max(weakening, 1.0e-6);
}

// A point light inside a cone: 1 on the axis, falling to 0 at the cone, linear in the cosine.
vec4 calcSpotLight(Material mat, SpotLight light, vec3 position, vec3 normal)
{
    vec3 fromLight = unit(position - light.pl.position);
    vec3 chord = fromLight - unit(light.conedir);
    float offAxis = 0.5 * dot(chord, chord); // 1 - cos, exact near the axis
    float factor = 1.0 - offAxis / max(1.0 - light.cutoff, 1.0e-9);
    if (factor <= 0.0)
    {
        return vec4(0.0);
    }
    return calcPointLight(mat, light.pl, position, normal) * factor;
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
