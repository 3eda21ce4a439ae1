#version 100
// The sun and the four point lights for OpenGL ES 2.0: `varying`, texture2D,
// gl_FragColor, and members with precisions of their own. No flashlight.

#ifdef GL_ES
precision mediump float;
#endif

// highp is optional in an ES 2.0 fragment shader.
#ifdef GL_FRAGMENT_PRECISION_HIGH
#define GEOMETRY highp
#define SMALL 1.0e-30
#else
#define GEOMETRY mediump
#define SMALL 1.0e-4
#endif

#define NR_POINT_LIGHTS 4

struct DirLight {
    vec3 direction;

    lowp vec3 ambient;
    lowp vec3 diffuse;
    lowp vec3 specular;
};

struct Material {
    sampler2D diffuse;
    sampler2D specular;
    float shininess;
};

struct PointLight {
    vec3 position;

    float constant;
    float linear;
    float quadratic;

    lowp vec3 ambient;
    lowp vec3 diffuse;
    lowp vec3 specular;
};

uniform DirLight dirLight;
uniform Material material;
uniform PointLight pointLights[NR_POINT_LIGHTS];
uniform vec3 viewPos;

varying GEOMETRY vec3 FragPos;
varying vec3 Normal;
varying vec2 TexCoords;

GEOMETRY vec3 unit(GEOMETRY vec3 v) {
    return v * inversesqrt(max(dot(v, v), SMALL));
}

// 1 - cos is half the squared chord. A light behind the surface has no highlight, and
// pow(0, 0) is undefined.
float highlight(GEOMETRY vec3 toLight, GEOMETRY vec3 normal, GEOMETRY vec3 viewDir, GEOMETRY float shininess) {
    GEOMETRY vec3 chord = toLight - reflect(-viewDir, normal);
    GEOMETRY float x = 1.0 - 0.5 * dot(chord, chord);
    return x > 0.0 && dot(normal, toLight) > 0.0 ? pow(x, shininess) : 0.0;
}

vec3 CalcDirLight(DirLight light, GEOMETRY vec3 normal, GEOMETRY vec3 viewDir) {
    GEOMETRY vec3 toLight = unit(-light.direction);
    vec3 surface = texture2D(material.diffuse, TexCoords).rgb;
    vec3 gloss = texture2D(material.specular, TexCoords).rgb;
    return (light.ambient + light.diffuse * max(dot(normal, toLight), 0.0)) * surface
         + light.specular * highlight(toLight, normal, viewDir, material.shininess) * gloss;
}

vec3 CalcPointLight(PointLight light, GEOMETRY vec3 normal, GEOMETRY vec3 fragPos, GEOMETRY vec3 viewDir) {
    GEOMETRY vec3 path = light.position - fragPos;
    GEOMETRY vec3 toLight = unit(path);
    GEOMETRY float d = length(path);
    GEOMETRY float weakening = max(light.constant + d * (light.linear + light.quadratic * d), 1.0e-4);
    vec3 surface = texture2D(material.diffuse, TexCoords).rgb;
    vec3 gloss = texture2D(material.specular, TexCoords).rgb;
    return ((light.ambient + light.diffuse * max(dot(normal, toLight), 0.0)) * surface
            + light.specular * highlight(toLight, normal, viewDir, material.shininess) * gloss) / weakening;
}

void main() {
    GEOMETRY vec3 normal = unit(Normal);
    GEOMETRY vec3 viewDir = unit(viewPos - FragPos);

    vec3 sum = CalcDirLight(dirLight, normal, viewDir);
    for (int i = 0; i < NR_POINT_LIGHTS; i++) {
        sum += CalcPointLight(pointLights[i], normal, FragPos, viewDir);
    }

    gl_FragColor = vec4(sum, 1.0);
}
