#pragma once
#include "CoreMinimal.h"

class FRunnable
{
public:
	virtual uint32 Run() = 0;
	virtual void Stop() {}
	virtual ~FRunnable() = default;
};
