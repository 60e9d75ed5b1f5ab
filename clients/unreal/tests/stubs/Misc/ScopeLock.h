#pragma once
#include "HAL/CriticalSection.h"
class FScopeLock
{
public:
	explicit FScopeLock(FCriticalSection* Mutex) : Guard(*Mutex) {}

private:
	std::lock_guard<FCriticalSection> Guard;
};
