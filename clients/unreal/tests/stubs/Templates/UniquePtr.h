#pragma once
#include "CoreMinimal.h"

template <class T> class TUniquePtr : public std::unique_ptr<T>
{
public:
	using std::unique_ptr<T>::unique_ptr;
	void Reset(T* Pointer = nullptr) { this->reset(Pointer); }
};
template <class T, class... A> TUniquePtr<T> MakeUnique(A&&... Arguments)
{
	return TUniquePtr<T>(new T(std::forward<A>(Arguments)...));
}
