// Captures a frame with a buffer that holds the bytes of a file, by RenderDoc's interface for programs.
// Arguments: the file, and the path of the capture without its ending.
#include <dlfcn.h>
#include <stdint.h>
#include <stdio.h>
#include <vulkan/vulkan.h>

enum { BYTES = 65536, HOST = VK_MEMORY_PROPERTY_HOST_VISIBLE_BIT | VK_MEMORY_PROPERTY_HOST_COHERENT_BIT };

#define MUST(call)                                                                                       \
  if (call) {                                                                                            \
    fprintf(stderr, "%s failed\n", #call);                                                               \
    return 1;                                                                                            \
  }

int main(int count, char **arguments) {
  void *library = dlopen("librenderdoc.so", RTLD_NOW);
  MUST(count != 3 || !library);
  // The table of functions of version 1.1.1.
  void *(*table)[32] = NULL;
  int (*get)(int, void **) = (int (*)(int, void **))dlsym(library, "RENDERDOC_GetAPI");
  MUST(get(10101, (void **)&table) != 1);
  void (*name_captures)(const char *) = (void (*)(const char *))(*table)[11];
  void (*start)(void *, void *) = (void (*)(void *, void *))(*table)[19];
  uint32_t (*end)(void *, void *) = (uint32_t(*)(void *, void *))(*table)[21];

  VkApplicationInfo about = {VK_STRUCTURE_TYPE_APPLICATION_INFO, .apiVersion = VK_API_VERSION_1_1};
  VkInstanceCreateInfo of_instance = {VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO, .pApplicationInfo = &about};
  VkInstance instance;
  MUST(vkCreateInstance(&of_instance, NULL, &instance));
  uint32_t one = 1;
  VkPhysicalDevice physical;
  vkEnumeratePhysicalDevices(instance, &one, &physical);
  MUST(one != 1);
  float priority = 1;
  VkDeviceQueueCreateInfo of_queue = {
      VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO, .queueCount = 1, .pQueuePriorities = &priority};
  VkDeviceCreateInfo of_device = {
      VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO, .queueCreateInfoCount = 1, .pQueueCreateInfos = &of_queue};
  VkDevice device;
  MUST(vkCreateDevice(physical, &of_device, NULL, &device));
  VkQueue queue;
  vkGetDeviceQueue(device, 0, 0, &queue);
  VkPhysicalDeviceMemoryProperties memories;
  vkGetPhysicalDeviceMemoryProperties(physical, &memories);

  VkBuffer buffers[2];
  void *mapped[2];
  for (int i = 0; i < 2; i++) {
    VkBufferCreateInfo of_buffer = {VK_STRUCTURE_TYPE_BUFFER_CREATE_INFO, .size = BYTES,
        .usage = VK_BUFFER_USAGE_TRANSFER_SRC_BIT | VK_BUFFER_USAGE_TRANSFER_DST_BIT};
    MUST(vkCreateBuffer(device, &of_buffer, NULL, &buffers[i]));
    VkMemoryRequirements needs;
    vkGetBufferMemoryRequirements(device, buffers[i], &needs);
    uint32_t type = 0;
    while ((memories.memoryTypes[type].propertyFlags & HOST) != HOST || !(needs.memoryTypeBits >> type & 1)) type++;
    VkMemoryAllocateInfo of_memory = {
        VK_STRUCTURE_TYPE_MEMORY_ALLOCATE_INFO, .allocationSize = needs.size, .memoryTypeIndex = type};
    VkDeviceMemory memory;
    MUST(vkAllocateMemory(device, &of_memory, NULL, &memory));
    MUST(vkBindBufferMemory(device, buffers[i], memory, 0));
    MUST(vkMapMemory(device, memory, 0, BYTES, 0, &mapped[i]));
  }
  FILE *file = fopen(arguments[1], "rb");
  MUST(!file || fread(mapped[0], 1, BYTES, file) != BYTES);
  fclose(file);

  VkCommandPoolCreateInfo of_pool = {VK_STRUCTURE_TYPE_COMMAND_POOL_CREATE_INFO};
  VkCommandPool pool;
  MUST(vkCreateCommandPool(device, &of_pool, NULL, &pool));
  VkCommandBufferAllocateInfo of_commands = {
      VK_STRUCTURE_TYPE_COMMAND_BUFFER_ALLOCATE_INFO, .commandPool = pool, .commandBufferCount = 1};
  VkCommandBuffer commands;
  MUST(vkAllocateCommandBuffers(device, &of_commands, &commands));
  name_captures(arguments[2]);
  start(NULL, NULL);
  VkCommandBufferBeginInfo begin = {VK_STRUCTURE_TYPE_COMMAND_BUFFER_BEGIN_INFO};
  MUST(vkBeginCommandBuffer(commands, &begin));
  VkBufferCopy all = {0, 0, BYTES};
  vkCmdCopyBuffer(commands, buffers[0], buffers[1], 1, &all);
  MUST(vkEndCommandBuffer(commands));
  VkSubmitInfo submit = {VK_STRUCTURE_TYPE_SUBMIT_INFO, .commandBufferCount = 1, .pCommandBuffers = &commands};
  MUST(vkQueueSubmit(queue, 1, &submit, VK_NULL_HANDLE));
  MUST(vkQueueWaitIdle(queue));
  MUST(end(NULL, NULL) != 1);
  return 0;
}
